//! Asks `cargo metadata`, and turns its answer into a [`Workspace`].

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use cargo_metadata::{DependencyKind, Metadata, TargetKind as Kind};
use serde::Deserialize;

use super::toolchain::{self, Failure};
use super::workspace::{Found, FoundDependency, FoundTarget, Workspace, normalized};
use super::{Features, Selection, TargetKind, manifest};

/// Asks cargo for the whole graph; without a lock file, or when that fails, for the members only.
///
/// The graph is asked for with `--frozen`: cargo then neither reaches for the network nor writes a lock file.
pub(super) fn load(
    manifest_path: &Path,
    directory: &Path,
    selection: &Selection,
    triple: Option<&str>,
    notices: &mut Vec<String>,
) -> Result<Workspace, Failure> {
    if depends_on_target(manifest_path) {
        let mut args = arguments(manifest_path, selection);
        args.push("--frozen".into());
        push_features(&mut args, selection);
        if let Some(triple) = triple {
            args.extend(["--filter-platform".into(), triple.into()]);
        }
        match toolchain::cargo(&args, directory).and_then(|json| parse(&json)) {
            Ok(workspace) => return Ok(workspace),
            Err(failure @ Failure::Tool(_)) => return Err(failure),
            Err(failure) => {
                let workspace = members_only(manifest_path, directory, selection)?;
                notices.push(format!(
                    "`cargo metadata` cannot resolve the dependencies without the network or a new lock file ({}); \
                     only the manifests are used",
                    failure.first_line()
                ));
                return Ok(workspace);
            }
        }
    }
    members_only(manifest_path, directory, selection)
}

/// Whether cargo resolves the dependencies, which are not the same for each target.
pub(super) fn depends_on_target(manifest_path: &Path) -> bool {
    lock_file(manifest_path).is_some()
}

fn members_only(manifest_path: &Path, directory: &Path, selection: &Selection) -> Result<Workspace, Failure> {
    let mut workspace = members(manifest_path, directory, selection)?;
    manifest::add_path_dependencies(&mut workspace);
    Ok(workspace)
}

fn members(manifest_path: &Path, directory: &Path, selection: &Selection) -> Result<Workspace, Failure> {
    let mut args = arguments(manifest_path, selection);
    args.extend(["--no-deps".into(), "--offline".into()]);
    toolchain::cargo(&args, directory).and_then(|json| parse(&json))
}

/// The lock file of a workspace of whose members alone cargo may be asked, because what it would say of their dependencies may
/// turn out not to matter; `None` if it has to be asked for them in any case.
///
/// To resolve the dependencies takes cargo longer than everything else takes the linter.
pub(super) fn lock_of_members(manifest_path: &Path, selection: &Selection) -> Option<String> {
    let lock = std::fs::read_to_string(lock_file(manifest_path)?).ok()?;
    let own = locked_packages(&lock).filter(|entry| !entry.contains("\nsource = ")).count();
    // A package that is checked alone is one that has something to check.
    (own >= 2 && !lock.contains("\"git+") && selection.features == Features::default()).then_some(lock)
}

fn locked_packages(lock: &str) -> impl Iterator<Item = &str> {
    lock.split("[[package]]").skip(1)
}

/// Asks cargo for the members only; `None` if something depends on their dependencies all the same.
pub(super) fn load_unresolved(
    lock: &str,
    manifest_path: &Path,
    directory: &Path,
    selection: &Selection,
) -> Option<Workspace> {
    let mut workspace = members(manifest_path, directory, selection).ok()?;
    let dependencies = workspace.packages.iter().flat_map(|found| &found.dependencies);
    let mut paths = dependencies.filter_map(|dependency| dependency.path.as_deref());
    let mut targets = workspace.packages.iter().flat_map(|found| &found.targets);
    if !paths.all(|path| workspace.packages.iter().any(|found| found.directory() == path))
        || targets.any(|target| !target.required_features.is_empty())
    {
        return None;
    }
    let name = |entry: &str| Some(entry.split_once("name = \"")?.1.split_once('"')?.0.to_owned());
    workspace.graph = locked_packages(lock).filter_map(name).collect();
    Some(workspace)
}

/// The lock file beside the manifest or above it, up to the root of the workspace.
fn lock_file(manifest_path: &Path) -> Option<PathBuf> {
    for directory in manifest_path.ancestors().skip(1) {
        let Ok(text) = std::fs::read_to_string(directory.join("Cargo.toml")) else { continue };
        let lock = directory.join("Cargo.lock");
        if lock.is_file() {
            return Some(lock);
        }
        // A lock file above a root belongs to another workspace.
        if toml::from_str::<toml::Table>(&text).is_ok_and(|manifest| manifest.contains_key("workspace")) {
            return None;
        }
    }
    None
}

fn arguments(manifest_path: &Path, selection: &Selection) -> Vec<OsString> {
    let mut args: Vec<OsString> = ["metadata", "--format-version", "1", "--color", "never"].map(Into::into).into();
    args.extend(["--manifest-path".into(), manifest_path.into()]);
    args.extend(selection.cargo_options.iter().map(Into::into));
    args
}

fn push_features(args: &mut Vec<OsString>, selection: &Selection) {
    if selection.features.all {
        args.push("--all-features".into());
    }
    if selection.features.no_default {
        args.push("--no-default-features".into());
    }
    if !selection.features.named.is_empty() {
        args.extend(["--features".into(), selection.features.named.join(",").into()]);
    }
}

/// The targets as cargo printed them, for messages that quote them.
#[derive(Deserialize)]
struct Verbatim {
    packages: Vec<VerbatimPackage>,
}

#[derive(Deserialize)]
struct VerbatimPackage {
    targets: Vec<serde_json::Value>,
}

fn parse(json: &str) -> Result<Workspace, Failure> {
    let wrong =
        |error: serde_json::Error| Failure::Tool(format!("`cargo metadata` printed what cannot be read: {error}"));
    let json = json.lines().find(|line| line.starts_with('{')).unwrap_or_default();
    let metadata: Metadata = serde_json::from_str(json).map_err(wrong)?;
    let verbatim: Verbatim = serde_json::from_str(json).map_err(wrong)?;
    Ok(convert(metadata, verbatim))
}

fn convert(metadata: Metadata, verbatim: Verbatim) -> Workspace {
    let graph = nodes_of(&metadata);
    let member_ids: BTreeSet<&str> = metadata.workspace_members.iter().map(|id| id.repr.as_str()).collect();
    let mut nodes: BTreeMap<&str, &cargo_metadata::Node> = BTreeMap::new();
    for node in metadata.resolve.iter().flat_map(|resolve| &resolve.nodes) {
        nodes.insert(&node.id.repr, node);
    }
    let mut members = Vec::new();
    let mut others = Vec::new();
    for (package, verbatim) in metadata.packages.iter().zip(verbatim.packages) {
        let is_member = member_ids.contains(package.id.repr.as_str());
        if is_member || package.source.is_none() {
            let found = convert_package(package, verbatim, nodes.get(package.id.repr.as_str()).copied());
            if is_member { members.push(found) } else { others.push(found) }
        }
    }
    members.sort_by(|a, b| a.manifest_path.cmp(&b.manifest_path));
    others.sort_by(|a, b| a.manifest_path.cmp(&b.manifest_path));
    let defaults = &metadata.workspace_default_members;
    let default_members = (0..members.len())
        .filter(|at| !defaults.is_available() || defaults.iter().any(|id| id.repr == members[*at].id))
        .collect();
    Workspace {
        root: metadata.workspace_root.into(),
        target_directory: metadata.target_directory.into(),
        members: members.len(),
        default_members,
        packages: members.into_iter().chain(others).collect(),
        is_resolved: metadata.resolve.is_some(),
        graph,
    }
}

/// The names of the packages that the resolved graph holds.
fn nodes_of(metadata: &Metadata) -> BTreeSet<String> {
    if metadata.resolve.is_none() {
        return BTreeSet::new();
    }
    metadata.packages.iter().map(|package| package.name.to_string()).collect()
}

fn convert_package(
    package: &cargo_metadata::Package,
    verbatim: VerbatimPackage,
    node: Option<&cargo_metadata::Node>,
) -> Found {
    let targets = package.targets.iter().zip(verbatim.targets).filter_map(|(target, cargo)| {
        let kind = target_kind(&target.kind)?;
        Some(FoundTarget {
            name: target.name.clone(),
            kind,
            src_path: normalized(target.src_path.as_std_path()),
            edition: target.edition.to_string(),
            required_features: target.required_features.clone(),
            is_tested: target.test,
            cargo,
        })
    });
    Found {
        name: package.name.to_string(),
        version: package.version.to_string(),
        id: package.id.repr.clone(),
        manifest_path: package.manifest_path.clone().into(),
        build_script: package
            .targets
            .iter()
            .find(|target| target.kind.contains(&Kind::CustomBuild))
            .map(|target| normalized(target.src_path.as_std_path())),
        targets: targets.collect(),
        features: package.features.clone(),
        dependencies: package.dependencies.iter().filter_map(convert_dependency).collect(),
        active: node.iter().flat_map(|node| &node.features).map(ToString::to_string).collect(),
        resolved: node
            .iter()
            .flat_map(|node| &node.deps)
            .map(|dependency| (dependency.name.clone(), dependency.pkg.repr.clone()))
            .collect(),
        metadata: package.metadata.get("ceid-lint").cloned(),
    }
}

fn convert_dependency(dependency: &cargo_metadata::Dependency) -> Option<FoundDependency> {
    // A build dependency is not in scope in any target that is read.
    (dependency.kind != DependencyKind::Build).then(|| FoundDependency {
        package_name: dependency.name.clone(),
        rename: dependency.rename.clone(),
        is_optional: dependency.optional,
        is_dev: dependency.kind == DependencyKind::Development,
        default_features: dependency.uses_default_features,
        features: dependency.features.clone(),
        path: dependency.path.as_ref().map(|path| normalized(&PathBuf::from(path))),
        is_git: dependency.source.as_ref().is_some_and(|source| source.repr.starts_with("git+")),
    })
}

fn target_kind(kinds: &[Kind]) -> Option<TargetKind> {
    kinds.iter().find_map(|kind| match kind {
        Kind::Lib | Kind::RLib | Kind::DyLib | Kind::CDyLib | Kind::StaticLib | Kind::ProcMacro => {
            Some(TargetKind::Lib)
        }
        Kind::Bin => Some(TargetKind::Bin),
        Kind::Example => Some(TargetKind::Example),
        Kind::Test => Some(TargetKind::Test),
        Kind::Bench => Some(TargetKind::Bench),
        _ => None,
    })
}
