//! From a workspace and what was selected in it to the [`Project`] that the analysis sees.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use super::workspace::{Found, FoundTarget, Workspace};
use super::{CfgValues, Dependency, Package, Project, Target, TargetKind};
use crate::diagnostic::Problem;

/// Builds the project: selected targets are reported, libraries are read for types.
pub(super) fn project(workspace: &Workspace, cfg: &CfgValues, selected: &BTreeSet<(usize, usize)>) -> Project {
    let by_id: BTreeMap<&str, usize> =
        workspace.packages.iter().enumerate().map(|(at, found)| (found.id.as_str(), at)).collect();
    let packages = workspace.packages.iter().enumerate().map(|(at, found)| Package {
        name: found.name.clone(),
        id: found.id.clone(),
        version: found.version.clone(),
        manifest_path: found.manifest_path.clone(),
        workspace_root: workspace.root.clone(),
        is_member: at < workspace.members,
        is_default: workspace.default_members.contains(&at),
        is_reported: found.targets.iter().enumerate().any(|(index, _)| selected.contains(&(at, index))),
        dependencies: dependencies(workspace, found, &by_id),
        targets: found
            .targets
            .iter()
            .enumerate()
            .filter(|(index, target)| target.kind == TargetKind::Lib || selected.contains(&(at, *index)))
            .map(|(index, target)| convert(target, selected.contains(&(at, index))))
            .collect(),
        roots_left_out: found
            .targets
            .iter()
            .enumerate()
            .filter(|(index, target)| target.kind != TargetKind::Lib && !selected.contains(&(at, *index)))
            .map(|(_, target)| &target.src_path)
            .chain(&found.build_script)
            .cloned()
            .collect(),
        is_partly_read: found
            .targets
            .iter()
            .enumerate()
            .any(|(index, target)| target.kind == TargetKind::Bin && !selected.contains(&(at, index))),
        cfg: cfg_of(found, cfg),
        is_unresolved: false,
        metadata: found.metadata.clone(),
    });
    Project {
        root: workspace.root.clone(),
        target_directory: workspace.target_directory.clone(),
        packages: packages.collect(),
        graph: graph(workspace),
        problems: selected_packages(selected)
            .flat_map(|at| lost_dependencies(workspace, &workspace.packages[at]))
            .collect(),
        ..Project::default()
    }
}

fn selected_packages(selected: &BTreeSet<(usize, usize)>) -> impl Iterator<Item = usize> {
    selected.iter().map(|(package, _)| *package).collect::<BTreeSet<_>>().into_iter()
}

/// The dependencies whose sources ought to be at hand, and are not.
fn lost_dependencies(workspace: &Workspace, found: &Found) -> Vec<Problem> {
    let is_lost = |path: &PathBuf| !workspace.packages.iter().any(|other| other.directory() == path);
    let lost = found.dependencies.iter().filter_map(|dependency| {
        let name = &dependency.package_name;
        let (message, help) = match &dependency.path {
            Some(path) if is_lost(path) => (
                format!("there is no package `{name}` in `{}`, which is a path dependency", path.display()),
                "what its code does is unknown; check out what is missing, as `git submodule update --init` does",
            ),
            None if dependency.is_git && !workspace.is_resolved => (
                format!("the git dependency `{name}` is not resolved without a lock file and its sources"),
                "what its code does is unknown; `cargo fetch` brings it",
            ),
            _ => return None,
        };
        let file = found.manifest_path.to_string_lossy().into_owned();
        Some(Problem { file, span: None, message, help: Some(help.to_owned()), is_error: false })
    });
    lost.collect()
}

/// The names of all packages in sight.
fn graph(workspace: &Workspace) -> BTreeSet<String> {
    let named = workspace.packages.iter().flat_map(|found| {
        let dependencies = found.dependencies.iter().map(|dependency| dependency.package_name.clone());
        dependencies.chain([found.name.clone()])
    });
    workspace.graph.iter().cloned().chain(named).collect()
}

fn convert(target: &FoundTarget, is_reported: bool) -> Target {
    Target {
        name: target.name.clone(),
        crate_name: target.crate_name(),
        kind: target.kind,
        src_path: target.src_path.clone(),
        edition: target.edition.clone(),
        is_reported,
        cfg_test: matches!(target.kind, TargetKind::Test | TargetKind::Bench),
        cargo: target.cargo.clone(),
    }
}

fn cfg_of(found: &Found, cfg: &CfgValues) -> CfgValues {
    let mut cfg = cfg.clone();
    cfg.values.insert("feature".to_owned(), found.active.clone());
    cfg
}

fn dependencies(workspace: &Workspace, found: &Found, by_id: &BTreeMap<&str, usize>) -> Vec<Dependency> {
    let mut dependencies = BTreeSet::new();
    let is_dev = |name: &str| {
        let mut own = found.dependencies.iter().filter(|own| own.package_name == name).peekable();
        own.peek().is_some() && own.all(|own| own.is_dev)
    };
    if workspace.is_resolved {
        for (extern_name, id) in &found.resolved {
            let package = by_id.get(id.as_str()).copied();
            let package_name = package.map_or_else(|| name_in_id(id), |at| workspace.packages[at].name.clone());
            let is_dev = is_dev(&package_name);
            dependencies.insert(Dependency { extern_name: extern_name.clone(), package_name, package, is_dev });
        }
        return dependencies.into_iter().collect();
    }
    for dependency in &found.dependencies {
        let package = dependency
            .path
            .as_ref()
            .and_then(|path| workspace.packages.iter().position(|other| other.directory() == path));
        let library =
            package.and_then(|at| workspace.packages[at].targets.iter().find(|it| it.kind == TargetKind::Lib));
        let extern_name = match (&dependency.rename, library) {
            (None, Some(library)) => library.crate_name(),
            _ => dependency.key().replace('-', "_"),
        };
        let package_name = dependency.package_name.clone();
        let is_dev = is_dev(&package_name);
        dependencies.insert(Dependency { extern_name, package_name, package, is_dev });
    }
    dependencies.into_iter().collect()
}

/// The package's name in an id: `…#name@1.0.0`, or the last part of the path in `…/name#1.0.0`.
fn name_in_id(id: &str) -> String {
    let (url, fragment) = id.split_once('#').unwrap_or((id, ""));
    match fragment.split_once('@') {
        Some((name, _)) => name.to_owned(),
        None => url.split('?').next().unwrap_or(url).trim_end_matches('/').rsplit('/').next().unwrap_or(url).to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_in_ids() {
        assert_eq!(name_in_id("registry+https://registry.example/index#pid@4.0.0"), "pid");
        assert_eq!(name_in_id("git+https://git.example/robots/ahrs?rev=1#0.2.0"), "ahrs");
        assert_eq!(name_in_id("path+file:///ws/control#0.1.0"), "control");
    }
}
