//! A workspace as it was found, whether cargo told or the manifests were read: everything before the selection.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::TargetKind;

/// A workspace, with the path dependencies outside it.
#[derive(Clone, Debug, Default)]
pub(super) struct Workspace {
    pub(super) root: PathBuf,
    pub(super) target_directory: PathBuf,
    /// The members first, then the path dependencies outside the workspace.
    pub(super) packages: Vec<Found>,
    /// How many of `packages` are members.
    pub(super) members: usize,
    /// What cargo would take when nothing is named.
    pub(super) default_members: Vec<usize>,
    /// Whether features and dependencies were resolved by cargo.
    pub(super) is_resolved: bool,
    /// The names of all packages of the dependency graph, if cargo resolved it.
    pub(super) graph: BTreeSet<String>,
}

/// A package as it was found.
#[derive(Clone, Debug, Default)]
pub(super) struct Found {
    pub(super) name: String,
    pub(super) version: String,
    pub(super) id: String,
    pub(super) manifest_path: PathBuf,
    pub(super) targets: Vec<FoundTarget>,
    /// The file of its build script.
    pub(super) build_script: Option<PathBuf>,
    /// The `[features]` with the implicit ones of optional dependencies left out.
    pub(super) features: BTreeMap<String, Vec<String>>,
    pub(super) dependencies: Vec<FoundDependency>,
    /// The features that are on.
    pub(super) active: BTreeSet<String>,
    /// cargo's own answer: the crate's name in `use`, and the package's id.
    pub(super) resolved: Vec<(String, String)>,
    pub(super) metadata: Option<serde_json::Value>,
}

impl Found {
    /// Whether only cargo can tell which features are on, or by which names the code calls its dependencies.
    pub(super) fn asks_cargo(&self) -> bool {
        !self.features.is_empty() || self.dependencies.iter().any(|it| it.is_optional || it.path.is_none())
    }

    pub(super) fn directory(&self) -> &Path {
        self.manifest_path.parent().unwrap_or(Path::new(""))
    }
}

/// A target as it was found.
#[derive(Clone, Debug)]
pub(super) struct FoundTarget {
    pub(super) name: String,
    pub(super) kind: TargetKind,
    pub(super) src_path: PathBuf,
    pub(super) edition: String,
    pub(super) required_features: Vec<String>,
    /// Whether `--tests` takes it.
    pub(super) is_tested: bool,
    pub(super) cargo: serde_json::Value,
}

impl FoundTarget {
    pub(super) fn crate_name(&self) -> String {
        self.name.replace('-', "_")
    }
}

/// A dependency as the manifest names it.
#[derive(Clone, Debug, Default)]
pub(super) struct FoundDependency {
    /// The package's own name.
    pub(super) package_name: String,
    /// The key in the manifest when it is another one.
    pub(super) rename: Option<String>,
    pub(super) is_optional: bool,
    pub(super) is_dev: bool,
    pub(super) default_features: bool,
    pub(super) features: Vec<String>,
    /// The directory it lies in, for a path dependency.
    pub(super) path: Option<PathBuf>,
    pub(super) is_git: bool,
}

impl FoundDependency {
    /// The name that features and the manifest call it by.
    pub(super) fn key(&self) -> &str {
        self.rename.as_deref().unwrap_or(&self.package_name)
    }
}

/// `.` and `..` taken out without asking the disk, so that a path reads as the user and cargo spell it.
pub(super) fn normalized(path: &Path) -> PathBuf {
    use std::path::Component;
    let mut result = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir => {
                if !matches!(result.components().next_back(), None | Some(Component::ParentDir | Component::RootDir)) {
                    result.pop();
                } else if !matches!(result.components().next_back(), Some(Component::RootDir)) {
                    result.push("..");
                }
            }
            other => result.push(other),
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(path: &str, expected: &str) {
        assert_eq!(normalized(Path::new(path)), Path::new(expected));
    }

    #[test]
    fn dots_are_taken_out() {
        check("/a/./b/../c", "/a/c");
        check("/a/b/../../..", "/");
    }

    #[test]
    fn leading_parents_of_a_relative_path_stay() {
        check("../a", "../a");
        check("a/../../b", "../b");
    }
}
