//! Source files and packages below a project that belong to nothing in it. Never reads a file: names decide.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::{Package, Project};
use crate::diagnostic::Problem;

/// How many directory entries are looked at: data may lie beside code.
const MAX_ENTRIES: usize = 200_000;

/// What was read of a project, by the paths that [`std::fs::canonicalize`] gives.
#[derive(Debug)]
pub struct Seen<'a> {
    /// The files that were read.
    pub read: &'a BTreeSet<PathBuf>,
    /// Files and directories of modules that are declared, and not there under this `cfg`.
    pub left_out: &'a BTreeSet<PathBuf>,
    /// Files that could not be read or parsed: what they declare is not known.
    pub broken: &'a [PathBuf],
}

/// The files that no target of the reported packages reads, and the packages beside them that are no members.
#[must_use]
pub fn strays(project: &Project, seen: &Seen<'_>) -> Vec<Problem> {
    let mut problems = Vec::new();
    let mut roots = BTreeSet::new();
    for package in project.packages.iter().filter(|package| package.is_reported) {
        let Some(directory) = package.manifest_path.parent().filter(|it| !it.as_os_str().is_empty()) else { continue };
        let is_whole = |other: &Package| other.is_reported || other.workspace_root != package.workspace_root;
        let is_whole = project.packages.iter().all(is_whole);
        roots.insert(if is_whole { package.workspace_root.clone() } else { directory.to_owned() });
    }
    let mut left = MAX_ENTRIES;
    let outer: Vec<PathBuf> =
        roots.iter().filter(|root| !root.ancestors().skip(1).any(|above| roots.contains(above))).cloned().collect();
    for root in outer {
        walk(project, &root, seen, &mut left, &mut problems);
    }
    problems
}

fn walk(project: &Project, root: &Path, seen: &Seen<'_>, left: &mut usize, problems: &mut Vec<Problem>) {
    let mut entries = walkdir::WalkDir::new(root).sort_by_file_name().into_iter();
    while let Some(entry) = entries.next() {
        *left = left.saturating_sub(1);
        if *left == 0 {
            return;
        }
        let Ok(entry) = entry else { continue };
        let path = entry.path();
        let name = entry.file_name().to_string_lossy();
        if entry.file_type().is_dir() {
            let is_skipped = entry.depth() > 0
                && (name.starts_with('.')
                    || name == "target"
                    || name == "node_modules"
                    || path == project.target_directory);
            if is_skipped {
                entries.skip_current_dir();
            } else if path.join("Cargo.toml").is_file()
                && !project.packages.iter().any(|package| package.manifest_path.parent() == Some(path))
                && entry.depth() > 0
            {
                entries.skip_current_dir();
                let is_told = seen.broken.contains(&path.join("Cargo.toml"));
                // What `cargo vendor` copied comes from elsewhere, as every other dependency.
                if !is_told && !path.join(".cargo-checksum.json").is_file() {
                    let help = format!("check it with `cargo ceid-lint {}`", shown(project, path));
                    problems.push(stray(&path.join("Cargo.toml"), "belongs to no package that is checked", help));
                }
            }
        } else if entry.file_type().is_file() && name.ends_with(".rs") && !is_known(project, path, seen) {
            let help = "declare it with `mod`, or name it to check it on its own".to_owned();
            problems.push(stray(path, "belongs to no target that is checked", help));
        }
    }
}

fn stray(path: &Path, message: &str, help: String) -> Problem {
    let file = path.to_string_lossy().into_owned();
    Problem { file, span: None, message: message.to_owned(), help: Some(help), is_error: false }
}

fn shown(project: &Project, path: &Path) -> String {
    path.strip_prefix(&project.root).unwrap_or(path).display().to_string()
}

/// Whether a file was read, or it cannot be said that nothing reads it.
fn is_known(project: &Project, path: &Path, seen: &Seen<'_>) -> bool {
    let canonical = std::fs::canonicalize(path);
    if canonical.as_ref().is_ok_and(|path| seen.read.contains(path))
        || path.ancestors().any(|above| seen.left_out.contains(above))
    {
        return true;
    }
    let Some(package) = owner(project, path) else { return false };
    let directory = package.manifest_path.parent().unwrap_or(Path::new(""));
    !package.is_reported
        || seen.broken.iter().any(|file| file.starts_with(directory))
        || package.roots_left_out.iter().any(|root| {
            let beside = root.parent().unwrap_or(Path::new(""));
            root == path || (beside != directory && path.starts_with(beside))
        })
}

/// The innermost package that the file lies in.
fn owner<'a>(project: &'a Project, path: &Path) -> Option<&'a Package> {
    let around = project.packages.iter().filter(|package| {
        package.manifest_path.parent().is_some_and(|it| !it.as_os_str().is_empty() && path.starts_with(it))
    });
    around.max_by_key(|package| package.manifest_path.components().count())
}
