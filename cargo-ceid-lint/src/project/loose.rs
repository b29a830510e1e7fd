//! Paths on the command line: which packages they belong to, and files that belong to none and are checked on their own.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::manifest;
use super::workspace::{Found, FoundTarget, Workspace, normalized};
use super::{LoadError, Selection, TargetKind};
use crate::diagnostic::Problem;

/// What the paths lead to.
#[derive(Debug, Default)]
pub(super) struct Roots {
    /// Manifests of packages and workspaces.
    pub(super) manifests: BTreeSet<PathBuf>,
    /// Files outside any package.
    pub(super) files: BTreeSet<PathBuf>,
    /// The paths themselves, absolute.
    pub(super) only: Vec<PathBuf>,
    /// Directories that cannot be looked into.
    pub(super) problems: Vec<Problem>,
}

/// Finds the packages and files that the paths of the selection lead to.
pub(super) fn find(selection: &Selection) -> Result<Roots, LoadError> {
    let mut roots = Roots::default();
    for path in &selection.paths {
        let absolute = normalized(&selection.current_dir.join(path));
        let shown = path.display();
        if absolute.is_file() || selection.unsaved.as_ref() == Some(path) {
            if absolute.file_name().is_some_and(|name| name == "Cargo.toml") {
                roots.manifests.insert(absolute.clone());
                roots.only.push(absolute.parent().unwrap_or(&absolute).to_owned());
                continue;
            }
            if absolute.extension().is_none_or(|extension| extension != "rs") {
                return Err(
                    LoadError::new(format!("`{shown}` is not a Rust file")).help("name a `.rs` file or a directory")
                );
            }
            match owner(&absolute) {
                Some(manifest) => roots.manifests.insert(manifest),
                None => roots.files.insert(absolute.clone()),
            };
        } else if absolute.is_dir() {
            let count = roots.manifests.len() + roots.files.len();
            directory(&absolute, &mut roots);
            if roots.manifests.len() + roots.files.len() == count
                && !roots.manifests.iter().any(|it| absolute.starts_with(it))
            {
                let is_known = roots.only.iter().any(|only| absolute.starts_with(only) || only.starts_with(&absolute));
                if !is_known {
                    return Err(LoadError::new(format!("`{shown}` holds no package and no `.rs` file"))
                        .help("name a directory with a `Cargo.toml`, or a `.rs` file"));
                }
            }
        } else {
            return Err(LoadError::new(format!("path `{shown}` does not exist"))
                .help(format!("it was looked for in `{}`", selection.current_dir.display())));
        }
        roots.only.push(absolute);
    }
    Ok(roots)
}

fn directory(directory: &Path, roots: &mut Roots) {
    let own = directory.join("Cargo.toml");
    if own.is_file() {
        roots.manifests.insert(own);
        return;
    }
    if let Some(manifest) = owner(directory) {
        roots.manifests.insert(manifest);
        return;
    }
    let mut files = BTreeSet::new();
    let mut entries = walkdir::WalkDir::new(directory).sort_by_file_name().into_iter();
    while let Some(entry) = entries.next() {
        let entry = match entry {
            Ok(entry) => entry,
            Err(error) => {
                let file = error.path().unwrap_or(directory).to_string_lossy().into_owned();
                let help = Some("make the directory readable, or name others".to_owned());
                let message = error.io_error().map_or_else(|| error.to_string(), ToString::to_string);
                roots.problems.push(Problem { file, span: None, message, help, is_error: true });
                continue;
            }
        };
        let name = entry.file_name().to_string_lossy();
        if entry.file_type().is_dir() {
            let manifest = entry.path().join("Cargo.toml");
            let is_skipped = entry.depth() > 0 && (name.starts_with('.') || name == "target" || name == "node_modules");
            if is_skipped {
                entries.skip_current_dir();
            } else if manifest.is_file() {
                roots.manifests.insert(manifest);
                entries.skip_current_dir();
            }
        } else if entry.path().extension().is_some_and(|extension| extension == "rs") && entry.path().is_file() {
            files.insert(entry.into_path());
        }
    }
    let modules: BTreeSet<PathBuf> = files.iter().flat_map(|file| modules_of(file)).collect();
    roots.files.extend(files.into_iter().filter(|file| !modules.contains(file)));
}

/// The manifest of the package that the path is source code of.
fn owner(path: &Path) -> Option<PathBuf> {
    path.ancestors()
        .skip(1)
        .map(|directory| directory.join("Cargo.toml"))
        .filter(|manifest| manifest.is_file() && manifest::has_package(manifest))
        .find(|manifest| manifest::owns(manifest, path))
}

/// The files that `mod name;` in `file` may mean: they are read with it, and are no programs of their own.
fn modules_of(file: &Path) -> Vec<PathBuf> {
    let Ok(text) = std::fs::read_to_string(file) else { return Vec::new() };
    let directory = file.parent().unwrap_or(Path::new(""));
    let stem = file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let directory =
        if ["main", "lib", "mod"].contains(&stem.as_str()) { directory.to_owned() } else { directory.join(stem) };
    let names = text.lines().filter_map(|line| {
        let line = line.trim();
        let declaration =
            line.strip_prefix("pub ").or_else(|| line.split_once(") ").map(|(_, rest)| rest)).unwrap_or(line);
        declaration.trim().strip_prefix("mod ")?.strip_suffix(';').map(str::trim)
    });
    names.flat_map(|name| [directory.join(format!("{name}.rs")), directory.join(name).join("mod.rs")]).collect()
}

/// A package for a file outside any package: edition 2024, no dependencies.
pub(super) fn package(file: &Path, text: &str) -> Workspace {
    let directory = file.parent().unwrap_or(Path::new("")).to_owned();
    let name = file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let (kind, word) = if text.contains("fn main(") { (TargetKind::Bin, "bin") } else { (TargetKind::Lib, "lib") };
    let kinds = [word.to_owned()];
    let target = FoundTarget {
        name: name.clone(),
        kind,
        src_path: file.to_owned(),
        edition: "2024".to_owned(),
        required_features: Vec::new(),
        is_tested: false,
        cargo: manifest::verbatim(&kinds, &kinds, &name, file, "2024"),
    };
    let found = Found {
        id: manifest::package_id(&directory, &name, "0.0.0"),
        name,
        version: "0.0.0".to_owned(),
        targets: vec![target],
        features: BTreeMap::new(),
        ..Found::default()
    };
    Workspace {
        target_directory: directory.join("target"),
        root: directory,
        packages: vec![found],
        members: 1,
        default_members: vec![0],
        ..Workspace::default()
    }
}
