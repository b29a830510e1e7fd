//! Which files may be written at all.

use std::collections::BTreeSet;
use std::fs::OpenOptions;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::interrupted::{Interrupted, interrupted, remove_notes};
use super::write::RealDisk;
use crate::project::Project;
use crate::source;

/// The workspaces of the packages that are checked, without what cargo builds.
#[derive(Clone, Debug, Default)]
pub struct Bounds {
    roots: Vec<PathBuf>,
    /// Repositories of packages of their own below them.
    nested: Vec<PathBuf>,
    target_directory: Option<PathBuf>,
}

impl Bounds {
    /// The bounds of a project.
    #[must_use]
    pub fn of(project: &Project) -> Self {
        let reported = || project.packages.iter().filter(|package| package.is_reported);
        let mut roots: Vec<PathBuf> =
            reported().filter_map(|package| package.workspace_root.canonicalize().ok()).collect();
        roots.sort();
        roots.dedup();
        let homes = reported().filter_map(|package| package.manifest_path.parent()?.canonicalize().ok());
        let repository = |home: PathBuf| {
            let mut inside = home.ancestors().take_while(|above| !roots.iter().any(|root| root == above));
            inside.find(|above| above.join(".git").exists()).map(Path::to_owned)
        };
        let mut nested: Vec<PathBuf> = homes.filter_map(repository).collect();
        nested.sort();
        nested.dedup();
        Self { roots, nested, target_directory: project.target_directory.canonicalize().ok() }
    }

    /// The directories whose version control is asked: the workspaces, and repositories below them that have packages of theirs.
    pub fn repositories(&self) -> impl Iterator<Item = &PathBuf> {
        self.roots.iter().chain(&self.nested)
    }

    /// The disk, with the notes of what is about to be replaced where [`interrupted`](Self::interrupted) looks for them.
    #[must_use]
    pub fn disk(&self) -> RealDisk {
        RealDisk { notes: self.roots.first().cloned() }
    }

    /// The runs that were ended when they had written some of the files that belong together, and not the others.
    #[must_use]
    pub fn interrupted(&self, now: SystemTime) -> Vec<Interrupted> {
        self.roots.iter().flat_map(|root| interrupted(root, now)).collect()
    }

    /// Removes what runs that were killed have left beside the files that may be written.
    pub fn remove_abandoned<'p>(&self, files: impl Iterator<Item = &'p Path>, now: SystemTime) {
        self.roots.iter().for_each(|root| remove_notes(root, now));
        let directories: BTreeSet<&Path> = files.filter_map(Path::parent).collect();
        let real = directories.into_iter().filter_map(|directory| directory.canonicalize().ok());
        for directory in real.filter(|real| self.roots.iter().any(|root| real.starts_with(root))) {
            source::remove_abandoned(&directory, now);
        }
    }

    /// The file itself, behind all symbolic links, if it may and can be written.
    ///
    /// # Errors
    /// Why it is not.
    pub fn file(&self, path: &Path) -> Result<PathBuf, String> {
        let unwritable = |why: &str| format!("cannot write `{}`: {why}", path.display());
        let real = path.canonicalize().map_err(|error| unwritable(&error.to_string()))?;
        let Some(root) = self.roots.iter().find(|root| real.starts_with(root)) else {
            return Err(unwritable("it lies outside the workspace"));
        };
        let built = self.target_directory.as_ref().filter(|directory| directory.starts_with(root));
        if built.is_some_and(|directory| real.starts_with(directory)) {
            return Err(unwritable("it lies in the target directory, which cargo writes"));
        }
        let metadata = real.metadata().map_err(|error| unwritable(&error.to_string()))?;
        if !metadata.is_file() {
            return Err(unwritable("it is not a regular file"));
        }
        if metadata.permissions().readonly() {
            return Err(unwritable("it is read-only"));
        }
        // Whether this user may write it, only the system knows.
        OpenOptions::new().write(true).open(&real).map_err(|error| unwritable(&error.to_string()))?;
        Ok(real)
    }
}
