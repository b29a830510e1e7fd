//! One check: loads the packages of a scope where they may have changed, reads the configuration, and checks.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use walkdir::WalkDir;

use super::check::{Extent, Judged, Outcome, Scope, Task};
use super::documents::identity;
use super::settings::Settings;
use crate::config;
use crate::pipeline::{self, Again, Memory, Options, Purpose};
use crate::project::{self, LoadError, Project};
use crate::source::ReadSource;

/// How deep packages are looked for in a folder that has no manifest.
const MOST_LEVELS: usize = 4;

/// How many entries of such a folder are looked at: it may be somebody's home.
const MOST_ENTRIES: usize = 20_000;

/// A project that was loaded, with what its manifests looked like then.
#[derive(Debug)]
pub(super) struct Loaded {
    project: Arc<Project>,
    paths: Vec<PathBuf>,
    settings: Settings,
    /// What lies below the folder that the client has open: it tells of changes there.
    within: Vec<Stamp>,
    beyond: Vec<Stamp>,
    /// What its last check has left.
    memory: Memory,
}

impl Loaded {
    /// Forgets what the last check has left.
    pub(super) fn forget(&mut self) {
        self.memory.forget();
    }
}

/// A file or directory that decides about packages and targets, with what tells whether it has changed.
type Stamp = (PathBuf, Option<(SystemTime, u64)>);

/// Checks a scope; the project is kept in `loaded`.
pub(super) fn check(task: &Task, loaded: &mut Option<Loaded>, source: &dyn Fn() -> Box<dyn ReadSource>) -> Outcome {
    let paths = match &task.scope {
        Scope::Folder(folder) => roots(folder),
        Scope::Elsewhere => task.files.clone(),
    };
    if paths.is_empty() {
        return Outcome::Nothing;
    }
    let is_as_before = |stamps: &[Stamp]| stamps.iter().all(|(path, stamp)| stamp_of(path) == *stamp);
    let is_known = loaded.as_ref().is_some_and(|loaded| {
        task.extent < Extent::Project
            && loaded.paths == paths
            && loaded.settings == task.settings
            && (task.extent == Extent::Texts || is_as_before(&loaded.within))
            && is_as_before(&loaded.beyond)
    });
    let current_dir = match &task.scope {
        Scope::Folder(folder) => folder,
        Scope::Elsewhere => paths[0].parent().unwrap_or(&paths[0]),
    };
    let selection = task.settings.selection(current_dir, paths.clone());
    if !is_known {
        *loaded = None;
        match project::load(&selection) {
            Ok(project) => {
                let is_within = |(path, _): &Stamp| matches!(&task.scope, Scope::Folder(it) if path.starts_with(it));
                let (within, beyond) = stamps(&project).into_iter().partition(is_within);
                let (project, settings) = (Arc::new(project), task.settings.clone());
                *loaded = Some(Loaded { project, paths, settings, within, beyond, memory: Memory::default() });
            }
            Err(error) => return not_loaded(error),
        }
    }
    let Some(Loaded { project, memory, .. }) = loaded else { return Outcome::Nothing };
    if task.extent > Extent::Texts {
        memory.forget();
    }
    let mut options = Options::default();
    if let Some(file) = &task.offered {
        memory.forget_checked_with(file);
        options.purpose = Purpose::Offers;
    }
    let mut checked = pipeline::check_again(project, &options, source(), memory);
    let alone = files_of_no_target(task, &checked);
    if !alone.is_empty() {
        match project::with_files(Project::clone(project), &alone, &selection) {
            Ok(whole) => *project = Arc::new(whole),
            Err(error) => return not_loaded(error),
        }
        memory.forget();
        checked = pipeline::check_again(project, &options, source(), memory);
    }
    let notices = if is_known { Vec::new() } else { project.notices.clone() };
    Outcome::Checked(Box::new(Judged { project: Arc::clone(project), reports: checked.parts, notices }))
}

/// The files that were named and that no target reads: they are checked on their own.
fn files_of_no_target(task: &Task, checked: &Again) -> Vec<PathBuf> {
    if checked.is_config_wrong || task.files.is_empty() {
        return Vec::new();
    }
    let files = checked.parts.iter().flat_map(|report| report.sources.files());
    let read: BTreeSet<PathBuf> = files.map(|(_, file)| identity(&file.path)).collect();
    let is_left_out = |file: &PathBuf| {
        checked.parts.iter().any(|report| file.ancestors().any(|above| report.left_out.contains(above)))
    };
    task.files.iter().filter(|file| !read.contains(*file) && !is_left_out(file)).cloned().collect()
}

fn not_loaded(error: LoadError) -> Outcome {
    let help = error.help.map(|help| format!("\nhelp: {help}")).unwrap_or_default();
    Outcome::NotLoaded { message: error.message + &help }
}

/// The folder itself if it belongs to a package or a workspace, or the packages below it.
fn roots(folder: &Path) -> Vec<PathBuf> {
    if folder.ancestors().any(|directory| directory.join("Cargo.toml").is_file()) {
        return vec![folder.to_owned()];
    }
    let mut found = Vec::new();
    let mut entries = WalkDir::new(folder).max_depth(MOST_LEVELS).sort_by_file_name().into_iter();
    for _ in 0..MOST_ENTRIES {
        let Some(entry) = entries.next() else { break };
        let Ok(entry) = entry else { continue };
        let name = entry.file_name().to_string_lossy();
        if entry.depth() == 0 || !entry.file_type().is_dir() {
            continue;
        }
        if entry.path().join("Cargo.toml").is_file() {
            found.push(entry.path().to_owned());
            entries.skip_current_dir();
        } else if name.starts_with('.') || name == "target" || name == "node_modules" {
            entries.skip_current_dir();
        }
    }
    found
}

/// What decides about the packages and targets of a project and about how it is checked: its manifests, the linter's
/// configuration, and the directories where targets are found.
fn stamps(project: &Project) -> Vec<Stamp> {
    let mut paths = Vec::new();
    for package in &project.packages {
        let root = &package.workspace_root;
        let names = ["Cargo.toml", "Cargo.lock", ".cargo/config.toml", config::FILE_NAME];
        paths.extend(names.map(|name| root.join(name)));
        let Some(directory) = package.manifest_path.parent().filter(|directory| directory.is_absolute()) else {
            continue;
        };
        let names = ["Cargo.toml", "src/lib.rs", "src/main.rs", "src/bin", "examples", "tests", "benches"];
        paths.extend(names.map(|name| directory.join(name)));
    }
    paths.sort();
    paths.dedup();
    paths.into_iter().map(|path| (stamp_of(&path), path)).map(|(stamp, path)| (path, stamp)).collect()
}

/// When a manifest or a directory was written last; of other files only whether they are there, for their text decides nothing.
fn stamp_of(path: &Path) -> Option<(SystemTime, u64)> {
    let metadata = path.metadata().ok()?;
    if path.extension().is_some_and(|extension| extension == "rs") {
        return Some((SystemTime::UNIX_EPOCH, 0));
    }
    Some((metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH), metadata.len()))
}
