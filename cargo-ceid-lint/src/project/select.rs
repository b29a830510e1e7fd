//! Which packages and targets are reported: cargo's own rules, with its words when something is not there.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::workspace::{Found, FoundTarget, Workspace};
use super::{LoadError, Names, Selection, TargetKind, package_spec};
use crate::config::{glob, spelling::nearest};

/// The indices of the selected packages, sorted.
pub(super) fn packages(
    workspace: &Workspace,
    selection: &Selection,
    only: &[PathBuf],
    notices: &mut Vec<String>,
) -> Result<Vec<usize>, LoadError> {
    if !selection.exclude.is_empty() && !selection.workspace {
        return Err(LoadError::new("--exclude can only be used together with --workspace"));
    }
    let members = &workspace.packages[..workspace.members];
    if members.is_empty() {
        let root = workspace.root.join("Cargo.toml");
        notices.push(format!("`{}` is a virtual manifest, and the workspace has no members", root.display()));
    }
    if selection.workspace {
        return Ok(all_but_excluded(workspace, selection, notices));
    }
    if selection.packages.is_empty() {
        return Ok(if only.is_empty() { workspace.default_members.clone() } else { touched(members, only) });
    }
    let mut selected = BTreeSet::new();
    for spec in &selection.packages {
        let named: Vec<usize> = (0..members.len()).filter(|at| package_spec::matches(spec, &members[*at])).collect();
        if named.is_empty() {
            return Err(unknown_package(spec, workspace));
        }
        selected.extend(named);
    }
    Ok(selected.into_iter().collect())
}

fn all_but_excluded(workspace: &Workspace, selection: &Selection, notices: &mut Vec<String>) -> Vec<usize> {
    let members = &workspace.packages[..workspace.members];
    for spec in &selection.exclude {
        if !members.iter().any(|found| package_spec::matches(spec, found)) {
            notices.push(format!("excluded package(s) `{spec}` not found in workspace `{}`", workspace.root.display()));
        }
    }
    let is_excluded = |found: &Found| selection.exclude.iter().any(|spec| package_spec::matches(spec, found));
    (0..members.len()).filter(|at| !is_excluded(&members[*at])).collect()
}

/// The packages that the paths lie in, and those that lie in the paths.
fn touched(members: &[Found], only: &[PathBuf]) -> Vec<usize> {
    let mut selected = BTreeSet::new();
    for path in only {
        let inside = (0..members.len()).filter(|at| members[*at].directory().starts_with(path));
        selected.extend(inside);
        let around = (0..members.len()).filter(|at| path.starts_with(members[*at].directory()));
        selected.extend(around.max_by_key(|at| members[*at].directory().components().count()));
    }
    selected.into_iter().collect()
}

fn unknown_package(spec: &str, workspace: &Workspace) -> LoadError {
    if glob::is_pattern(spec) {
        let root = workspace.root.display();
        return LoadError::new(format!("package pattern(s) `{spec}` not found in workspace `{root}`"));
    }
    let error = LoadError::new(format!("package ID specification `{spec}` did not match any packages"));
    let members = &workspace.packages[..workspace.members];
    let name = spec.rsplit(['/', '#']).next().unwrap_or(spec).split('@').next().unwrap_or(spec);
    if let Some(found) = members.iter().find(|found| found.name == name) {
        return error.help(format!("there is a similar package ID specification: `{}@{}`", found.name, found.version));
    }
    error.similar("package", nearest(spec, members.iter().map(|found| found.name.as_str())))
}

/// The selected targets as pairs of indices: package and target.
pub(super) fn targets(
    workspace: &Workspace,
    packages: &[usize],
    selection: &Selection,
    only: &[PathBuf],
) -> Result<BTreeSet<(usize, usize)>, LoadError> {
    let filter = &selection.targets;
    let mut selected = BTreeSet::new();
    let kinds = [
        (TargetKind::Bin, &filter.bins),
        (TargetKind::Example, &filter.examples),
        (TargetKind::Test, &filter.tests),
        (TargetKind::Bench, &filter.benches),
    ];
    let is_default = !filter.lib && !filter.all && kinds.iter().all(|(_, names)| **names == Names::default());
    for at in packages {
        for (index, target) in workspace.packages[*at].targets.iter().enumerate() {
            let is_taken = if is_default {
                matches!(target.kind, TargetKind::Lib | TargetKind::Bin | TargetKind::Example) || is_meant(target, only)
            } else {
                filter.all || is_taken_by_kind(target, selection)
            };
            let is_enabled = missing_features(&workspace.packages[*at], target).is_empty();
            if is_taken && is_enabled {
                selected.insert((*at, index));
            }
        }
    }
    if filter.lib && !has_library(workspace, packages) {
        return Err(LoadError::new(format!(
            "no library targets found in {}",
            where_looked(workspace, packages, selection)
        )));
    }
    for (kind, names) in kinds {
        for name in &names.named {
            selected.extend(named_targets(workspace, packages, selection, kind, name)?);
        }
    }
    Ok(selected)
}

/// Whether a path names the target's own file or directory: who names a test wants it checked.
fn is_meant(target: &FoundTarget, only: &[PathBuf]) -> bool {
    target.src_path.parent().is_some_and(|directory| only.iter().any(|path| path.starts_with(directory)))
}

fn is_taken_by_kind(target: &FoundTarget, selection: &Selection) -> bool {
    let filter = &selection.targets;
    // `--tests` and `--benches` take the library and the binaries too, which cargo builds as unit tests.
    let by_tests = filter.tests.all && target.is_tested;
    match target.kind {
        TargetKind::Lib => filter.lib || by_tests || filter.benches.all,
        TargetKind::Bin => filter.bins.all || by_tests || filter.benches.all,
        TargetKind::Example => filter.examples.all || by_tests,
        TargetKind::Test => by_tests,
        TargetKind::Bench => filter.benches.all || by_tests,
    }
}

fn has_library(workspace: &Workspace, packages: &[usize]) -> bool {
    packages.iter().any(|at| workspace.packages[*at].targets.iter().any(|target| target.kind == TargetKind::Lib))
}

fn named_targets(
    workspace: &Workspace,
    packages: &[usize],
    selection: &Selection,
    kind: TargetKind,
    name: &str,
) -> Result<Vec<(usize, usize)>, LoadError> {
    let mut named = Vec::new();
    let mut known = Vec::new();
    for at in packages {
        let found = &workspace.packages[*at];
        for (index, target) in found.targets.iter().enumerate().filter(|(_, target)| target.kind == kind) {
            known.push(target.name.as_str());
            if glob::matches(name, &target.name) {
                let missing = missing_features(found, target);
                if !missing.is_empty() && !glob::is_pattern(name) {
                    let message = format!(
                        "target `{name}` in package `{}` requires the features: {}",
                        found.name,
                        missing.join(", ")
                    );
                    return Err(LoadError::new(message)
                        .help(format!("turn them on with `--features \"{}\"`", missing.join(" "))));
                }
                named.push((*at, index));
            }
        }
    }
    if !named.is_empty() {
        return Ok(named);
    }
    let word = kind.name();
    let place = where_looked(workspace, packages, selection);
    let error = LoadError::new(format!("no {word} target named `{name}` in {place}"));
    Err(match nearest(name, known.iter().copied()) {
        Some(similar) => error.similar("target", Some(similar)),
        None if known.is_empty() => error,
        None => error.help(format!("available {word} targets: {}", known.join(", "))),
    })
}

fn missing_features<'a>(found: &Found, target: &'a FoundTarget) -> Vec<&'a str> {
    target.required_features.iter().filter(|name| !found.active.contains(*name)).map(String::as_str).collect()
}

fn where_looked(workspace: &Workspace, packages: &[usize], selection: &Selection) -> String {
    if selection.packages.is_empty() && !selection.workspace {
        return "default-run packages".to_owned();
    }
    let names: Vec<String> = packages.iter().map(|at| format!("`{}`", workspace.packages[*at].name)).collect();
    format!("{} package{}", names.join(", "), if names.len() == 1 { "" } else { "s" })
}

/// Whether a path lies in the directory of one of the package's crate roots.
pub(super) fn owns(found: &Found, path: &Path) -> bool {
    found.targets.iter().filter_map(|target| target.src_path.parent()).any(|directory| path.starts_with(directory))
}
