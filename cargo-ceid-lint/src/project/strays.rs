//! Source files and packages below a project that belong to nothing that is checked. Never reads a file: names decide.

use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::{Package, Project};
use crate::diagnostic::Problem;

/// How many directory entries are looked at: data may lie beside code.
const MAX_ENTRIES: usize = 200_000;

/// What was read of a project.
#[derive(Debug)]
pub struct Seen<'a> {
    /// The files that were read.
    pub read: &'a BTreeSet<&'a Path>,
    /// The packages that nobody looked into, because there is no filter in them.
    pub unparsed: &'a BTreeSet<usize>,
    /// The packages with cycles that are no members of the workspace.
    pub beside: &'a BTreeSet<usize>,
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
    let packages = project.packages.iter().enumerate();
    let directories = packages.filter_map(|(number, package)| Some((package.manifest_path.parent()?, number)));
    let places = Places {
        project,
        seen,
        directories: directories.filter(|(directory, _)| !directory.as_os_str().is_empty()).collect(),
        canonical: OnceCell::new(),
    };
    let beside = seen.beside.iter().map(|number| &project.packages[*number]);
    for package in beside.filter(|package| !package.is_reported) {
        let Some(directory) = package.manifest_path.parent() else { continue };
        if directory.starts_with(&project.root) && !directory.join(".cargo-checksum.json").is_file() {
            problems.push(of_no_package(project, directory));
        }
    }
    let mut left = MAX_ENTRIES;
    let outer: Vec<PathBuf> =
        roots.iter().filter(|root| !root.ancestors().skip(1).any(|above| roots.contains(above))).cloned().collect();
    for root in outer {
        walk(&places, &root, &mut left, &mut problems);
    }
    problems
}

fn walk(places: &Places<'_>, root: &Path, left: &mut usize, problems: &mut Vec<Problem>) {
    let (project, seen) = (places.project, places.seen);
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
                    || path == project.target_directory
                    || places.is_unparsed(path));
            if is_skipped {
                entries.skip_current_dir();
            } else if path.join("Cargo.toml").is_file() && !places.directories.contains_key(path) && entry.depth() > 0 {
                entries.skip_current_dir();
                let is_told = seen.broken.contains(&path.join("Cargo.toml"));
                // What `cargo vendor` copied comes from elsewhere, as every other dependency.
                if !is_told && !path.join(".cargo-checksum.json").is_file() {
                    problems.push(of_no_package(project, path));
                }
            }
        } else if entry.file_type().is_file() && name.ends_with(".rs") && !places.is_known(path) {
            let help = "declare it with `mod`, or name it to check it on its own".to_owned();
            problems.push(stray(path, "belongs to no target that is checked", help));
        }
    }
}

fn of_no_package(project: &Project, directory: &Path) -> Problem {
    let help = format!("check it with `cargo ceid-lint {}`", shown(project, directory));
    stray(&directory.join("Cargo.toml"), "belongs to no package that is checked", help)
}

fn stray(path: &Path, message: &str, help: String) -> Problem {
    let file = path.to_string_lossy().into_owned();
    Problem { file, span: None, message: message.to_owned(), help: Some(help), is_error: false }
}

fn shown(project: &Project, path: &Path) -> String {
    path.strip_prefix(&project.root).unwrap_or(path).display().to_string()
}

/// A project with what was read of it, for quick questions.
struct Places<'a> {
    project: &'a Project,
    seen: &'a Seen<'a>,
    /// The directories of the packages, with their numbers.
    directories: BTreeMap<&'a Path, usize>,
    /// The one path that each file has for the system, of the files that were read.
    canonical: OnceCell<BTreeSet<PathBuf>>,
}

impl Places<'_> {
    /// Whether nobody looked into the package in this directory, nor into one below it.
    fn is_unparsed(&self, directory: &Path) -> bool {
        let is_unparsed = |number: &usize| self.seen.unparsed.contains(number);
        self.directories.get(directory).is_some_and(is_unparsed)
            && self
                .directories
                .range(directory..)
                .take_while(|(below, _)| below.starts_with(directory))
                .all(|(_, number)| is_unparsed(number))
    }

    /// Whether a file was read, or it cannot be said that nothing reads it.
    fn is_known(&self, path: &Path) -> bool {
        let seen = self.seen;
        if seen.read.contains(path) || path.ancestors().any(|above| seen.left_out.contains(above)) {
            return true;
        }
        let canonical =
            || seen.read.iter().filter_map(|path| std::fs::canonicalize(path).ok()).collect::<BTreeSet<PathBuf>>();
        if std::fs::canonicalize(path).is_ok_and(|path| self.canonical.get_or_init(canonical).contains(&path)) {
            return true;
        }
        // The innermost package that the file lies in.
        let owner = path.ancestors().find_map(|above| self.directories.get(above));
        let Some(package) = owner.map(|number| &self.project.packages[*number]) else { return false };
        let directory = package.manifest_path.parent().unwrap_or(Path::new(""));
        !package.is_reported
            || owner.is_some_and(|number| seen.unparsed.contains(number))
            || seen.broken.iter().any(|file| file.starts_with(directory))
            || package.roots_left_out.iter().any(|root| {
                let beside = root.parent().unwrap_or(Path::new(""));
                root == path || (beside != directory && path.starts_with(beside))
            })
    }
}
