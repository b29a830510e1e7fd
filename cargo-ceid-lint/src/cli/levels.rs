//! The levels of the command line, in the order in which they were written.

use clap::ArgMatches;

use super::args::LevelArgs;
use crate::config::{LevelOverrides, LevelSource};
use crate::diagnostic::Level;
use crate::rules;

const FLAGS: &[(&str, &str, &str, Level)] = &[
    ("allow", "-A", "--allow", Level::Allow),
    ("warn", "-W", "--warn", Level::Warn),
    ("deny", "-D", "--deny", Level::Deny),
    ("forbid", "-F", "--forbid", Level::Forbid),
];

/// Reads `--strict`, then the flags in their order, then those behind `--`. Takes forbidden rules out of the features.
///
/// # Errors
/// What to say about a name that is no rule and no group, or about an argument behind `--` that is no level.
pub(super) fn read(
    matches: &ArgMatches,
    args: &LevelArgs,
    features: &mut Vec<String>,
    rest: &[String],
) -> Result<LevelOverrides, String> {
    let mut overrides = LevelOverrides::default();
    if args.strict {
        for name in ["gated_update", "unproved_update"] {
            overrides.push(name, Level::Deny, LevelSource::CommandLine("--strict".to_owned()));
        }
    }
    let mut found: Vec<(usize, String, &str, Level)> = Vec::new();
    for (id, short, _, level) in FLAGS {
        let values = matches.get_many::<String>(id).into_iter().flatten().cloned();
        let indices = matches.indices_of(id).into_iter().flatten();
        found.extend(indices.zip(values).map(|(at, name)| (at, name, *short, *level)));
    }
    let indices = matches.indices_of("features").into_iter().flatten();
    let forbidden: Vec<(usize, String)> =
        indices.zip(features.iter().cloned()).filter(|(_, name)| is_rule(name)).collect();
    features.retain(|name| !is_rule(name));
    found.extend(forbidden.into_iter().map(|(at, name)| (at, name, "-F", Level::Forbid)));
    found.sort_by_key(|(at, ..)| *at);
    for (_, name, flag, level) in found {
        push(&mut overrides, &name, flag, level)?;
    }
    read_rest(rest, &mut overrides)?;
    Ok(overrides)
}

/// Whether a value of `-F`, which cargo has for features, can only mean a rule or a group of ours.
fn is_rule(name: &str) -> bool {
    let is_common_word = name == rules::ALL || name == rules::WARNINGS;
    name.starts_with("ceid::") || (!is_common_word && rules::unknown_name(name).is_none())
}

fn push(overrides: &mut LevelOverrides, name: &str, flag: &str, level: Level) -> Result<(), String> {
    if let Some(message) = rules::unknown_name(name) {
        return Err(message);
    }
    overrides.push(name, level, LevelSource::CommandLine(format!("{flag} {name}")));
    Ok(())
}

/// Reads arguments as rustc takes them: `-W x`, `-Wx`, `--warn x`, `--warn=x`.
fn read_rest(rest: &[String], overrides: &mut LevelOverrides) -> Result<(), String> {
    let mut arguments = rest.iter();
    while let Some(argument) = arguments.next() {
        if let Some(value) = argument.strip_prefix("--cap-lints") {
            if value.is_empty() {
                arguments.next();
            }
            continue;
        }
        let flag = FLAGS.iter().find_map(|(_, short, long, level)| {
            let attached = argument.strip_prefix(long).or_else(|| argument.strip_prefix(short))?;
            Some((*short, attached.trim_start_matches('=').to_owned(), *level))
        });
        let Some((short, attached, level)) = flag else {
            return Err(format!(
                "unexpected argument `{argument}` behind `--`; levels are expected there, as in `-W ceid::gated_update`"
            ));
        };
        let name = if attached.is_empty() { arguments.next().cloned().unwrap_or_default() } else { attached };
        // Lints of other tools may stand there too, where an editor calls several checkers alike.
        if !name.contains("::") || name.starts_with("ceid::") {
            push(overrides, &name, short, level)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, FromArgMatches};

    use super::super::args::Cli;
    use super::*;

    fn levels(line: &str) -> Result<(Vec<String>, Vec<String>), String> {
        let matches = Cli::command().try_get_matches_from(line.split(' ')).unwrap();
        let cli = Cli::from_arg_matches(&matches).unwrap();
        let mut features = cli.check.input.build.features;
        let overrides = read(&matches, &cli.check.levels, &mut features, &cli.check.rest)?;
        let entries = overrides.entries().iter().map(|it| format!("{} {}", it.level.name(), it.name)).collect();
        Ok((entries, features))
    }

    #[track_caller]
    fn check(line: &str, expected: &[&str]) {
        assert_eq!(levels(line).unwrap().0, expected);
    }

    #[test]
    fn flags_keep_their_order() {
        check(
            "cargo-ceid-lint -A missed_update -D ceid::missed_update -W all -A proof",
            &["allow missed_update", "deny missed_update", "warn all", "allow proof"],
        );
    }

    #[test]
    fn flags_behind_the_dashes_come_last() {
        check("cargo-ceid-lint -D warnings -- -W ceid::proof -Aall", &["deny warnings", "warn proof", "allow all"]);
        check("cargo-ceid-lint -- --deny=all --cap-lints warn -W clippy::pedantic", &["deny all"]);
    }

    #[test]
    fn strict_can_be_softened() {
        check(
            "cargo-ceid-lint -A gated_update --strict",
            &["deny gated_update", "deny unproved_update", "allow gated_update"],
        );
    }

    #[test]
    fn a_feature_is_told_from_a_forbidden_rule() {
        let (entries, features) = levels("cargo-ceid-lint -F std,imu -F missed_update -F ceid::all -F all").unwrap();
        assert_eq!(entries, ["forbid missed_update", "forbid all"]);
        assert_eq!(features, ["std,imu", "all"]);
    }

    #[test]
    fn unknown_names_are_corrected() {
        assert!(levels("cargo-ceid-lint -D mised_update").unwrap_err().contains("did you mean `ceid::missed_update`?"));
        assert!(levels("cargo-ceid-lint -- src/main.rs").unwrap_err().contains("`src/main.rs`"));
    }
}
