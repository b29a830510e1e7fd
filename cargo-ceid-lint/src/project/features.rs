//! Which features are on when cargo did not resolve them: defaults, what the command line names, and what follows from both.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::workspace::Workspace;
use super::{Features, LoadError};
use crate::config::spelling::nearest;

/// Fills `active` of every package of the workspace; the features that are named are those of the packages `selected`.
///
/// # Errors
/// If the command line names a feature that none of these has.
pub(super) fn activate(workspace: &mut Workspace, flags: &Features, selected: &[usize]) -> Result<(), LoadError> {
    let by_directory: BTreeMap<PathBuf, usize> =
        workspace.packages.iter().enumerate().map(|(at, found)| (found.directory().to_owned(), at)).collect();
    let mut solver = Solver { workspace, by_directory, work: Vec::new() };
    for member in 0..solver.workspace.members {
        let found = &solver.workspace.packages[member];
        if flags.all {
            let all: Vec<String> = found.features.keys().cloned().chain(optional(found)).collect();
            solver.work.extend(all.into_iter().map(|feature| (member, feature)));
        } else if !flags.no_default {
            solver.work.push((member, "default".to_owned()));
        }
        solver.required_dependencies(member);
    }
    for feature in &flags.named {
        solver.turn_on(feature, selected)?;
    }
    solver.run();
    Ok(())
}

struct Solver<'a> {
    workspace: &'a mut Workspace,
    by_directory: BTreeMap<PathBuf, usize>,
    /// Features that are to be turned on.
    work: Vec<(usize, String)>,
}

impl Solver<'_> {
    fn turn_on(&mut self, feature: &str, selected: &[usize]) -> Result<(), LoadError> {
        let (package, name) = feature.split_once('/').map_or((None, feature), |(package, name)| (Some(package), name));
        let mut is_known = false;
        for member in 0..self.workspace.members {
            let found = &self.workspace.packages[member];
            let has = found.features.contains_key(name) || optional(found).any(|optional| optional == name);
            let is_meant = package.map_or_else(|| selected.contains(&member), |package| package == found.name);
            if is_meant && has {
                is_known = true;
                self.work.push((member, name.to_owned()));
            } else if let Some(package) = package
                && found.dependencies.iter().any(|dependency| dependency.key() == package)
            {
                is_known = true;
                self.follow(member, feature);
            }
        }
        if is_known || selected.is_empty() {
            return Ok(());
        }
        let members = || selected.iter().map(|member| &self.workspace.packages[*member]);
        let known: Vec<&str> = members().flat_map(|found| found.features.keys().map(String::as_str)).collect();
        let names: Vec<&str> = members().map(|found| found.name.as_str()).collect();
        let message = match names.as_slice() {
            [name] => format!("the package `{name}` does not contain the feature `{feature}`"),
            _ => format!(
                "none of the selected packages contains the feature `{feature}`; selected: {}",
                names.join(", ")
            ),
        };
        Err(LoadError::new(message).similar("feature", nearest(name, known)))
    }

    fn run(&mut self) {
        while let Some((at, feature)) = self.work.pop() {
            let found = &mut self.workspace.packages[at];
            let implied = found.features.get(&feature).cloned();
            let is_optional = optional(found).any(|name| name == feature);
            if (implied.is_some() || is_optional) && found.active.insert(feature.clone()) {
                for value in implied.unwrap_or_default() {
                    self.follow(at, &value);
                }
                if is_optional {
                    self.enter(at, &feature);
                }
            }
        }
    }

    /// Turns on what one entry of a feature's list says.
    fn follow(&mut self, at: usize, value: &str) {
        if let Some(dependency) = value.strip_prefix("dep:") {
            self.enter(at, dependency);
        } else if let Some((dependency, feature)) = value.split_once('/') {
            let (dependency, is_weak) = dependency.strip_suffix('?').map_or((dependency, false), |name| (name, true));
            if let Some(target) = self.package_of(at, dependency) {
                self.work.push((target, feature.to_owned()));
            }
            if !is_weak {
                self.work.push((at, dependency.to_owned()));
                self.enter(at, dependency);
            }
        } else {
            self.work.push((at, value.to_owned()));
        }
    }

    /// Turns on what the dependency entry asks of the package it names.
    fn enter(&mut self, at: usize, key: &str) {
        let Some(target) = self.package_of(at, key) else { return };
        for dependency in self.workspace.packages[at].dependencies.iter().filter(|dependency| dependency.key() == key) {
            let defaults = dependency.default_features.then(|| "default".to_owned());
            self.work.extend(dependency.features.iter().cloned().chain(defaults).map(|feature| (target, feature)));
        }
    }

    fn required_dependencies(&mut self, at: usize) {
        let keys: Vec<String> = self.workspace.packages[at]
            .dependencies
            .iter()
            .filter(|dependency| !dependency.is_optional)
            .map(|dependency| dependency.key().to_owned())
            .collect();
        for key in keys {
            self.enter(at, &key);
        }
    }

    fn package_of(&self, at: usize, key: &str) -> Option<usize> {
        let dependencies = &self.workspace.packages[at].dependencies;
        let path = dependencies.iter().filter(|dependency| dependency.key() == key).find_map(|it| it.path.as_ref())?;
        self.by_directory.get(path).copied()
    }
}

/// The features that optional dependencies are, when no `dep:` hides them.
fn optional(found: &super::workspace::Found) -> impl Iterator<Item = String> {
    let is_hidden = |key: &str| {
        let hidden = format!("dep:{key}");
        found.features.values().flatten().any(|value| *value == hidden)
    };
    let names =
        found.dependencies.iter().filter(|it| it.is_optional && !is_hidden(it.key())).map(|it| it.key().to_owned());
    names.collect::<Vec<_>>().into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::project::workspace::{Found, FoundDependency};

    fn demo() -> Workspace {
        let features =
            [("default", vec!["std"]), ("std", vec![]), ("imu", vec!["dep:hal", "hal/fast"]), ("gps", vec!["imu"])];
        let demo = Found {
            name: "demo".to_owned(),
            manifest_path: "/ws/demo/Cargo.toml".into(),
            features: features
                .map(|(name, list)| (name.to_owned(), list.into_iter().map(str::to_owned).collect()))
                .into_iter()
                .collect(),
            dependencies: vec![FoundDependency {
                package_name: "hal".to_owned(),
                is_optional: true,
                path: Some("/ws/hal".into()),
                ..FoundDependency::default()
            }],
            ..Found::default()
        };
        let hal = Found {
            name: "hal".to_owned(),
            manifest_path: "/ws/hal/Cargo.toml".into(),
            features: [("fast".to_owned(), vec![]), ("default".to_owned(), vec![])].into(),
            ..Found::default()
        };
        Workspace { packages: vec![demo, hal], members: 1, ..Workspace::default() }
    }

    #[track_caller]
    fn check(flags: &Features, demo_features: &[&str], hal_features: &[&str]) {
        let mut workspace = demo();
        activate(&mut workspace, flags, &[0]).unwrap();
        let active = |at: usize| workspace.packages[at].active.iter().map(String::as_str).collect::<Vec<_>>();
        assert_eq!(active(0), demo_features);
        assert_eq!(active(1), hal_features);
    }

    fn named(features: &[&str], no_default: bool) -> Features {
        Features { named: features.iter().map(|name| (*name).to_owned()).collect(), all: false, no_default }
    }

    #[test]
    fn defaults_are_on_unless_refused() {
        check(&Features::default(), &["default", "std"], &[]);
        check(&named(&[], true), &[], &[]);
    }

    #[test]
    fn what_follows_from_a_feature_is_on_too() {
        check(&named(&["gps"], true), &["gps", "imu"], &["fast"]);
        check(&named(&["demo/imu"], true), &["imu"], &["fast"]);
    }

    #[test]
    fn all_features_are_all() {
        check(&Features { all: true, ..Features::default() }, &["default", "gps", "imu", "std"], &["fast"]);
    }

    #[test]
    fn an_unknown_feature_is_an_error_with_the_nearest_one() {
        let error = activate(&mut demo(), &named(&["gsp"], false), &[0]).unwrap_err();
        assert!(error.message.contains("`gsp`") && error.help.unwrap().contains("`gps`"));
    }

    #[test]
    fn a_feature_of_a_package_that_is_not_selected_is_an_error() {
        let both = || Workspace { members: 2, ..demo() };
        let told = |name: &str, selected: &[usize]| {
            activate(&mut both(), &named(&[name], false), selected).err().map(|error| error.message)
        };
        assert_eq!(told("fast", &[0]).unwrap(), "the package `demo` does not contain the feature `fast`");
        assert_eq!(told("fast", &[0, 1]), None);
        assert!(told("slow", &[0, 1]).unwrap().ends_with("selected: demo, hal"));
    }
}
