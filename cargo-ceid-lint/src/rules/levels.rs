//! Which level a rule has, and why: defaults, then the configuration, then the command line.

use super::{ALL, GROUPS, RULES, Rule, WARNINGS};
use crate::config::spelling::nearest;
use crate::config::{Config, ConfigError, LevelOverride, LevelSource};
use crate::diagnostic::Level;
use crate::project::Package;

/// A level, and where it comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// The level.
    pub level: Level,
    /// "by default", "on the command line", "in `ceid-lint.toml`"
    pub source: String,
}

/// The level of a rule in a package.
///
/// Within one `[lints]` table the higher priority wins, and at the same priority the narrower name: a rule over its group, a
/// group over `all`. The package's table wins over the workspace's, the command line over both, and there the last one wins.
#[must_use]
pub fn level_of(rule: &Rule, config: &Config, package: &Package) -> Setting {
    let mut setting = Setting { level: rule.default_level, source: "by default".to_owned() };
    let mut warnings = None;
    let mut apply = |entry: &LevelOverride| {
        if entry.name == WARNINGS {
            warnings = Some(from(entry));
        } else if breadth(&entry.name, rule).is_some() {
            setting = from(entry);
        }
    };
    for section in config.sections_of(&package.workspace_root, &package.manifest_path) {
        let mut entries: Vec<&LevelOverride> = section.lints.iter().collect();
        entries.sort_by_key(|entry| (entry.priority, std::cmp::Reverse(breadth(&entry.name, rule))));
        entries.into_iter().for_each(&mut apply);
    }
    config.overrides.entries().iter().for_each(&mut apply);
    match warnings {
        Some(warnings) if setting.level == Level::Warn => warnings,
        _ => setting,
    }
}

fn from(entry: &LevelOverride) -> Setting {
    Setting { level: entry.level, source: entry.source.phrase() }
}

/// How much more than the rule a name covers; `None` if it does not cover the rule.
fn breadth(name: &str, rule: &Rule) -> Option<u8> {
    match name {
        _ if name == rule.name => Some(0),
        _ if name == rule.group.name() => Some(1),
        ALL => Some(2),
        _ => None,
    }
}

/// All names that a level can be given to, without prefix.
fn names() -> Vec<&'static str> {
    let rules = RULES.iter().map(|rule| rule.name);
    rules.chain(GROUPS.iter().map(|group| group.name())).chain([ALL, WARNINGS]).collect()
}

/// What to say about a name that is no rule and no group; `None` if it is one.
#[must_use]
pub fn unknown_name(name: &str) -> Option<String> {
    let name = name.strip_prefix("ceid::").unwrap_or(name);
    let names = names();
    if names.contains(&name) {
        return None;
    }
    let advice = match nearest(name, names) {
        Some(similar) => format!("did you mean `ceid::{similar}`?"),
        None => "`cargo ceid-lint rules` lists all of them".to_owned(),
    };
    Some(format!("unknown rule or group `ceid::{name}`; {advice}"))
}

/// Checks that the configuration names only rules and groups that there are.
///
/// # Errors
/// The unknown names, with their places and the nearest right spellings.
pub fn validate(config: &Config) -> Result<(), ConfigError> {
    let mut errors = Vec::new();
    for (section, entry) in config.sections.iter().flat_map(|section| section.lints.iter().map(move |it| (section, it)))
    {
        if let LevelSource::File(place) = &entry.source
            && !names().contains(&entry.name.as_str())
        {
            let error = ConfigError::at(place.clone(), format!("unknown rule or group `{}`", entry.name));
            errors.push(error.did_you_mean(&entry.name, &names()).in_text(&section.text));
        }
    }
    ConfigError::all(errors).map_or(Ok(()), Err)
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use super::*;
    use crate::config::{Place, Scope, Section};
    use crate::project::CfgValues;

    fn package() -> Package {
        Package {
            name: "demo".to_owned(),
            id: String::new(),
            version: String::new(),
            manifest_path: "/ws/demo/Cargo.toml".into(),
            workspace_root: "/ws".into(),
            is_reported: true,
            is_unresolved: false,
            dependencies: Vec::new(),
            targets: Vec::new(),
            cfg: CfgValues::default(),
            roots_left_out: Vec::new(),
            is_member: true,
            is_default: true,
            is_partly_read: false,
            metadata: None,
        }
    }

    fn section(scope: Scope, path: &str, lints: &[(&str, Level, i64)]) -> Section {
        let place = Place { path: PathBuf::from(path), line: 1, column: 1, range: 0..0 };
        let lints = lints.iter().map(|(name, level, priority)| LevelOverride {
            name: (*name).to_owned(),
            level: *level,
            priority: *priority,
            source: LevelSource::File(place.clone()),
        });
        Section {
            scope,
            path: place.path.clone(),
            text: "".into(),
            presets: None,
            exclude: Vec::new(),
            lints: lints.collect(),
            filters: Vec::new(),
            cycles: Vec::new(),
            guards: Vec::new(),
        }
    }

    fn workspace(lints: &[(&str, Level, i64)]) -> Section {
        section(Scope::Workspace("/ws".into()), "/ws/ceid-lint.toml", lints)
    }

    #[track_caller]
    fn check(sections: Vec<Section>, flags: &[(&str, Level)], rule: &str, level: Level, source: &str) {
        let mut config = Config { sections, ..Config::default() };
        for (name, level) in flags {
            config.overrides.push(name, *level, LevelSource::CommandLine(String::new()));
        }
        let setting = level_of(super::super::find(rule).unwrap(), &config, &package());
        assert_eq!((setting.level, setting.source.as_str()), (level, source));
    }

    #[test]
    fn nobody_asked() {
        check(vec![], &[], "skipped_update", Level::Warn, "by default");
    }

    #[test]
    fn the_last_flag_wins() {
        let flags = [("ceid::missed_update", Level::Allow), ("missed_update", Level::Warn)];
        check(vec![], &flags, "missed_update", Level::Warn, "on the command line");
        check(
            vec![],
            &[("missed_update", Level::Allow), ("all", Level::Deny)],
            "missed_update",
            Level::Deny,
            "on the command line",
        );
    }

    #[test]
    fn warnings_are_the_rules_at_warn() {
        check(vec![], &[("warnings", Level::Deny)], "skipped_update", Level::Deny, "on the command line");
        check(vec![], &[("warnings", Level::Deny)], "gated_update", Level::Allow, "by default");
        check(vec![], &[("warnings", Level::Allow)], "missed_update", Level::Deny, "by default");
    }

    #[test]
    fn a_rule_wins_over_its_group_at_the_same_priority() {
        let lints = [("skipped_update", Level::Deny, 0), ("suspicious", Level::Allow, 0), ("all", Level::Warn, 0)];
        check(vec![workspace(&lints)], &[], "skipped_update", Level::Deny, "in `ceid-lint.toml`");
        let lints = [("skipped_update", Level::Deny, 0), ("suspicious", Level::Allow, 1)];
        check(vec![workspace(&lints)], &[], "skipped_update", Level::Allow, "in `ceid-lint.toml`");
    }

    #[test]
    fn the_package_wins_over_the_workspace_and_the_flag_over_both() {
        let own = || {
            let scope = Scope::Package("/ws/demo/Cargo.toml".into());
            section(scope, "/ws/demo/Cargo.toml", &[("all", Level::Warn, 0)])
        };
        let shared = || workspace(&[("missed_update", Level::Forbid, 9)]);
        check(vec![shared(), own()], &[], "missed_update", Level::Warn, "in `Cargo.toml`");
        check(
            vec![shared(), own()],
            &[("missed_update", Level::Deny)],
            "missed_update",
            Level::Deny,
            "on the command line",
        );
        let other =
            section(Scope::Package("/ws/other/Cargo.toml".into()), "/ws/other/Cargo.toml", &[("all", Level::Allow, 0)]);
        check(vec![other], &[], "missed_update", Level::Deny, "by default");
    }

    #[test]
    fn unknown_names_are_corrected() {
        assert_eq!(unknown_name("ceid::correctness"), None);
        assert_eq!(unknown_name("warnings"), None);
        assert!(unknown_name("mised_update").unwrap().contains("`ceid::missed_update`"));
        let config = Config { sections: vec![workspace(&[("skiped_update", Level::Deny, 0)])], ..Config::default() };
        let error = validate(&config).unwrap_err();
        assert_eq!(error.place.as_ref().map(|place| place.path.as_path()), Some(Path::new("/ws/ceid-lint.toml")));
        assert_eq!(error.help.as_deref(), Some("did you mean `skipped_update`?"));
    }
}
