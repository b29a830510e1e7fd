//! The command line: reads the arguments, runs, prints, and answers the exit code. The only module that prints.

mod args;
mod baseline;
mod beside;
mod bug;
mod check;
mod command;
mod console;
mod exit;
mod explain;
mod fix;
mod format;
mod init;
mod input;
mod interrupted;
mod levels;
mod lsp;
mod migrate;
mod progress;
mod report;
mod rules;
mod timings;
mod unread;
mod vcs;

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{ArgMatches, CommandFactory, FromArgMatches};

use args::{Cli, Command};
use console::Console;
use exit::ExitStatus;

/// Runs the program with `args`, the first of which is its own name.
///
/// Never panics: a bug ends in a message that asks to report it.
pub fn run(args: impl IntoIterator<Item = OsString>) -> ExitCode {
    let args: Vec<OsString> = without_subcommand_name(args);
    let status = bug::caught(|| run_caught(args));
    if console::tell_cut_off() { ExitStatus::Incomplete } else { status }.into()
}

/// cargo calls `cargo-ceid-lint ceid-lint ARGS`.
fn without_subcommand_name(args: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let mut args: Vec<OsString> = args.into_iter().collect();
    if args.get(1).is_some_and(|name| name == "ceid-lint") {
        args.remove(1);
    }
    args
}

fn parsed(args: &[OsString]) -> Result<(Cli, ArgMatches), clap::Error> {
    let matches = Cli::command().try_get_matches_from(args)?;
    Ok((Cli::from_arg_matches(&matches)?, matches))
}

/// The arguments with the subcommand in front, if it was written behind flags, as cargo takes it: `--offline report`.
fn with_subcommand_first(cli: &Cli, args: &[OsString]) -> Option<Vec<OsString>> {
    let command = Cli::command();
    let is_subcommand = |path: &&PathBuf| command.get_subcommands().any(|own| path.as_os_str() == own.get_name());
    let paths = cli.command.is_none().then_some(&cli.check.input.paths)?;
    let name = paths.iter().find(is_subcommand).filter(|path| !path.exists())?.as_os_str();
    let mut args = args.to_vec();
    let at = args.iter().rposition(|arg| arg == name)?;
    let name = args.remove(at);
    args.insert(1, name);
    Some(args)
}

/// The arguments with each word in front that is the name of a subcommand.
fn subcommands_first(args: &[OsString]) -> impl Iterator<Item = Vec<OsString>> {
    let command = Cli::command();
    let is_name = move |arg: &OsString| command.get_subcommands().any(|own| arg.as_os_str() == own.get_name());
    (2..args.len()).filter(move |at| is_name(&args[*at])).map(|at| {
        let mut args = args.to_vec();
        let name = args.remove(at);
        args.insert(1, name);
        args
    })
}

fn run_caught(args: Vec<OsString>) -> ExitStatus {
    let first = parsed(&args).and_then(|first| match with_subcommand_first(&first.0, &args) {
        Some(args) => parsed(&args),
        None => Ok(first),
    });
    // Flags of the subcommand may stand behind flags that all have, and before its name only those are known.
    let first = first.or_else(|error| {
        let mut others = subcommands_first(&args).filter(|_| error.use_stderr());
        others.find_map(|args| parsed(&args).ok()).ok_or(error)
    });
    let (cli, matches) = match first {
        Ok(parsed) => parsed,
        Err(error) => return usage(&error),
    };
    let result = match cli.command {
        None => check::run(cli.check, &matches),
        Some(Command::Check(args)) => check::run(*args, of_subcommand(&matches)),
        Some(Command::Fix(mut args)) => {
            args.fixes.fix = true;
            check::run(*args, of_subcommand(&matches))
        }
        Some(Command::Report(args)) => report::run(*args, of_subcommand(&matches)),
        Some(Command::Baseline(args)) => baseline::run(*args, of_subcommand(&matches)),
        Some(Command::Explain(args)) => explain::run(&args),
        Some(Command::Rules(args)) => Ok(rules::run(&args)),
        Some(Command::Init(args)) => init::run(&args),
        Some(Command::Migrate(args)) => migrate::run(&args),
        Some(Command::Lsp(_)) => Ok(lsp::run()),
        Some(Command::Completions(args)) => command::completions(&args),
        Some(Command::Man) => command::manual(),
    };
    result.unwrap_or_else(|message| usage(&Cli::command().error(clap::error::ErrorKind::InvalidValue, message)))
}

fn of_subcommand(matches: &ArgMatches) -> &ArgMatches {
    matches.subcommand().map_or(matches, |(_, matches)| matches)
}

/// Prints help, the version, or what is wrong with the arguments.
fn usage(error: &clap::Error) -> ExitStatus {
    let _ = error.print();
    if error.use_stderr() { ExitStatus::Usage } else { ExitStatus::Clean }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(args: &[&str], expected: &[&str]) {
        assert_eq!(without_subcommand_name(args.iter().map(OsString::from)), expected);
    }

    #[test]
    fn the_name_that_cargo_adds_is_dropped_once() {
        check(&["cargo-ceid-lint", "ceid-lint", "-q"], &["cargo-ceid-lint", "-q"]);
        check(&["cargo-ceid-lint", "-q"], &["cargo-ceid-lint", "-q"]);
        check(&["cargo-ceid-lint", "ceid-lint", "ceid-lint"], &["cargo-ceid-lint", "ceid-lint"]);
        check(&["cargo-ceid-lint"], &["cargo-ceid-lint"]);
    }
}
