//! Reads manifests as TOML: for path dependencies that cargo was not asked about, and for whole workspaces when no cargo can be
//! run. Knows cargo's rules of discovery, and resolves no versions.

mod dependencies;
mod targets;

pub(super) use targets::verbatim;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use toml::{Table, Value};

use super::workspace::{Found, Workspace, normalized};
use super::{LoadError, TargetKind};
use crate::config::glob;
use crate::diagnostic::Problem;

/// A manifest that was read.
struct Manifest {
    path: PathBuf,
    table: Table,
}

impl Manifest {
    fn read(path: &Path) -> Result<Self, LoadError> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| LoadError::new(format!("cannot read manifest `{}`: {error}", path.display())))
            .map_err(|error| error.help("make it readable, or take it out of what names it"))?;
        let table = toml::from_str(&text).map_err(|error: toml::de::Error| {
            let at = error.span().map_or(0, |span| u32::try_from(span.start).unwrap_or(0));
            let place = crate::source::LineIndex::default().line_column(&text, at);
            LoadError::new(format!("`{}:{}:{}`: {}", path.display(), place.line, place.column, error.message()))
                .help("correct the manifest; `cargo check` reports the same")
        })?;
        Ok(Self { path: path.to_owned(), table })
    }

    fn directory(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    fn section(&self, name: &str) -> Option<&Table> {
        self.table.get(name)?.as_table()
    }

    /// A value of `[package]`, taken from `[workspace.package]` where it says `workspace = true`.
    fn package_value<'a>(&'a self, key: &str, workspace: Option<&'a Self>) -> Option<&'a Value> {
        let value = self.section("package")?.get(key)?;
        if value.get("workspace").and_then(Value::as_bool) == Some(true) {
            return workspace?.section("workspace")?.get("package")?.get(key);
        }
        Some(value)
    }
}

/// The nearest `Cargo.toml` in `directory` or above it.
pub(super) fn nearest(directory: &Path) -> Option<PathBuf> {
    directory.ancestors().map(|ancestor| ancestor.join("Cargo.toml")).find(|path| path.is_file())
}

/// Whether the manifest describes a package; unreadable ones count, so that their error is shown.
pub(super) fn has_package(path: &Path) -> bool {
    Manifest::read(path).map_or(true, |manifest| manifest.section("package").is_some())
}

/// Whether `path` lies in the directory of a crate root of the package that the manifest describes.
pub(super) fn owns(manifest: &Path, path: &Path) -> bool {
    let found = Manifest::read(manifest).and_then(|manifest| read_package(&manifest, None));
    // A package whose manifest is wrong owns all that lies below, so that its error is shown.
    found.map_or(true, |found| super::select::owns(&found, path))
}

/// Reads the workspace that the manifest at `path` belongs to, without cargo. Members that cannot be read are left out, and told.
pub(super) fn read_workspace(path: &Path, problems: &mut Vec<Problem>) -> Result<Workspace, LoadError> {
    let manifest = Manifest::read(path)?;
    if manifest.section("package").is_none() && manifest.section("workspace").is_none() {
        return Err(LoadError::new(format!("`{}` has neither `[package]` nor `[workspace]`", path.display()))
            .help("name the manifest of a package or of a workspace"));
    }
    let root = workspace_root(&manifest)?;
    let mut workspace = Workspace {
        root: root.directory().to_owned(),
        target_directory: root.directory().join("target"),
        ..Workspace::default()
    };
    let mut paths = member_manifests(&root);
    if root.section("package").is_some() {
        paths.insert(root.path.clone());
    }
    for path in paths {
        match Manifest::read(&path).and_then(|manifest| read_package(&manifest, Some(&root))) {
            Ok(found) => workspace.packages.push(found),
            Err(error) => problems.push(error.problem(&path)),
        }
    }
    workspace.members = workspace.packages.len();
    add_path_dependencies(&mut workspace);
    // Path dependencies inside the workspace are members without being named.
    let is_inside = |found: &Found| found.manifest_path.starts_with(&workspace.root);
    let (mut members, others): (Vec<Found>, Vec<Found>) = workspace.packages.drain(..).partition(is_inside);
    members.sort_by(|a, b| a.manifest_path.cmp(&b.manifest_path));
    workspace.members = members.len();
    workspace.packages = members.into_iter().chain(others).collect();
    workspace.default_members = default_members(&workspace, &root, path);
    Ok(workspace)
}

/// Adds the packages that path dependencies name and that are not there yet, and theirs in turn.
pub(super) fn add_path_dependencies(workspace: &mut Workspace) {
    let mut known: BTreeSet<PathBuf> = workspace.packages.iter().map(|found| found.manifest_path.clone()).collect();
    let mut at = 0;
    while at < workspace.packages.len() {
        let is_member = at < workspace.members;
        let paths: Vec<PathBuf> = workspace.packages[at]
            .dependencies
            .iter()
            .filter(|dependency| is_member || !dependency.is_dev)
            .filter_map(|dependency| Some(dependency.path.as_ref()?.join("Cargo.toml")))
            .collect();
        for path in paths {
            // One that cannot be read is as unknown as one from a registry.
            if known.insert(path.clone())
                && let Ok(manifest) = Manifest::read(&path)
                && let Ok(root) = workspace_root(&manifest)
                && let Ok(found) = read_package(&manifest, Some(&root))
            {
                workspace.packages.push(found);
            }
        }
        at += 1;
    }
}

/// The manifest with the `[workspace]` that `manifest` belongs to; itself if there is none.
fn workspace_root(manifest: &Manifest) -> Result<Manifest, LoadError> {
    let itself = || Manifest { path: manifest.path.clone(), table: manifest.table.clone() };
    if manifest.section("workspace").is_some() {
        return Ok(itself());
    }
    if let Some(root) = manifest.section("package").and_then(|package| package.get("workspace")?.as_str()) {
        return Manifest::read(&normalized(&manifest.directory().join(root)).join("Cargo.toml"));
    }
    for directory in manifest.directory().ancestors().skip(1) {
        let path = directory.join("Cargo.toml");
        if path.is_file()
            && let Ok(root) = Manifest::read(&path)
            && root.section("workspace").is_some()
        {
            return Ok(if holds(&root, manifest) { root } else { itself() });
        }
    }
    Ok(itself())
}

/// Whether `manifest` is a member of `root`, by name or as a path dependency of a member.
fn holds(root: &Manifest, manifest: &Manifest) -> bool {
    let named = member_manifests(root);
    named.contains(&manifest.path) || {
        let mut workspace = Workspace::default();
        for path in named.iter().chain([&root.path]) {
            workspace.packages.extend(Manifest::read(path).and_then(|member| read_package(&member, Some(root))));
        }
        workspace.members = workspace.packages.len();
        let directory = manifest.directory();
        workspace.packages.iter().flat_map(|found| &found.dependencies).any(|it| it.path.as_deref() == Some(directory))
    }
}

fn member_manifests(root: &Manifest) -> BTreeSet<PathBuf> {
    let excluded: Vec<PathBuf> =
        workspace_list(root, "exclude").iter().map(|path| normalized(&root.directory().join(path))).collect();
    let mut manifests = BTreeSet::new();
    for pattern in workspace_list(root, "members") {
        for directory in directories(root.directory(), pattern.trim_start_matches("./").trim_end_matches('/')) {
            let manifest = directory.join("Cargo.toml");
            // A directory that is only named by a pattern need not be a package.
            if (manifest.is_file() || !glob::is_pattern(&pattern))
                && !excluded.iter().any(|it| directory.starts_with(it))
            {
                manifests.insert(manifest);
            }
        }
    }
    manifests
}

fn workspace_list(root: &Manifest, key: &str) -> Vec<String> {
    let list = root.section("workspace").and_then(|workspace| workspace.get(key)?.as_array());
    list.into_iter().flatten().filter_map(|value| value.as_str().map(str::to_owned)).collect()
}

/// The directories below `root` that a members pattern names.
fn directories(root: &Path, pattern: &str) -> Vec<PathBuf> {
    if !glob::is_pattern(pattern) {
        return vec![normalized(&root.join(pattern))];
    }
    let depth = if pattern.contains("**") { 16 } else { pattern.split('/').count() };
    walkdir::WalkDir::new(root)
        .max_depth(depth)
        .into_iter()
        .filter_entry(|entry| entry.depth() == 0 || !entry.file_name().to_string_lossy().starts_with('.'))
        .flatten()
        .filter(|entry| entry.file_type().is_dir())
        .filter(|entry| {
            let relative = entry.path().strip_prefix(root).unwrap_or(entry.path());
            glob::matches(pattern, &relative.to_string_lossy().replace('\\', "/"))
        })
        .map(walkdir::DirEntry::into_path)
        .collect()
}

fn default_members(workspace: &Workspace, root: &Manifest, asked: &Path) -> Vec<usize> {
    let of = |wanted: &dyn Fn(&Found) -> bool| -> Vec<usize> {
        (0..workspace.members).filter(|at| wanted(&workspace.packages[*at])).collect()
    };
    if asked != root.path {
        return of(&|found| found.manifest_path == asked);
    }
    let named = workspace_list(root, "default-members");
    if !named.is_empty() {
        let named: Vec<PathBuf> = named.iter().flat_map(|pattern| directories(root.directory(), pattern)).collect();
        return of(&|found| named.iter().any(|directory| directory == found.directory()));
    }
    if root.section("package").is_some() { of(&|found| found.manifest_path == root.path) } else { of(&|_| true) }
}

fn read_package(manifest: &Manifest, workspace: Option<&Manifest>) -> Result<Found, LoadError> {
    let Some(package) = manifest.section("package") else {
        return Err(LoadError::new(format!("`{}` has no `[package]`", manifest.path.display()))
            .help("take it out of the members, or add `[package]`"));
    };
    let Some(name) = package.get("name").and_then(Value::as_str) else {
        return Err(LoadError::new(format!("`{}`: `[package]` has no `name`", manifest.path.display()))
            .help("add `name = \"…\"` to `[package]`"));
    };
    let text = |key: &str, default: &str| {
        manifest.package_value(key, workspace).and_then(Value::as_str).unwrap_or(default).to_owned()
    };
    let (version, edition) = (text("version", "0.0.0"), text("edition", "2015"));
    let features: BTreeMap<String, Vec<String>> = manifest
        .section("features")
        .into_iter()
        .flatten()
        .map(|(name, list)| {
            let list = list.as_array().into_iter().flatten();
            (name.clone(), list.filter_map(|value| value.as_str().map(str::to_owned)).collect())
        })
        .collect();
    Ok(Found {
        name: name.to_owned(),
        id: package_id(manifest.directory(), name, &version),
        version,
        manifest_path: manifest.path.clone(),
        build_script: build_script(manifest, package),
        targets: targets::discover(manifest, name, &edition),
        features,
        dependencies: dependencies::read(manifest, workspace),
        metadata: package
            .get("metadata")
            .and_then(|metadata| metadata.get("ceid-lint"))
            .and_then(|value| serde_json::to_value(value).ok()),
        ..Found::default()
    })
}

fn build_script(manifest: &Manifest, package: &Table) -> Option<PathBuf> {
    let path = match package.get("build") {
        Some(Value::Boolean(false)) => return None,
        Some(Value::String(path)) => path.as_str(),
        _ => "build.rs",
    };
    Some(manifest.directory().join(path)).filter(|path| path.is_file())
}

/// The id that cargo gives to a package at a path.
pub(super) fn package_id(directory: &Path, name: &str, version: &str) -> String {
    let directory = directory.to_string_lossy().replace('\\', "/");
    let slash = if directory.starts_with('/') { "" } else { "/" };
    if directory.rsplit('/').next() == Some(name) {
        format!("path+file://{slash}{directory}#{version}")
    } else {
        format!("path+file://{slash}{directory}#{name}@{version}")
    }
}

#[cfg(test)]
mod tests;
