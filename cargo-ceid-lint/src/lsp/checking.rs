//! When the code is checked, and what its checks tell: newest first, and everything that is shown is of one state.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::check::{Checked, Extent, Job, Outcome, Scope, Task};
use super::documents::identity;
use super::findings;
use super::server::{Phase, Progress, Server};
use super::view::{Part, Unit};

/// How long the code stays as it is before it is checked: shorter than the pause between two words.
pub(super) const PAUSE: Duration = Duration::from_millis(50);

impl Server {
    /// A file is another than before, on the disk or in the editor.
    pub(super) fn changed(&mut self, path: &Path, pause: Option<Duration>) {
        // Who does not tell of changes on the disk may have made some.
        let is_typed = pause.is_some() && self.client.watches_files;
        for scope in self.scopes_of(path) {
            self.recheck(scope, if is_typed { Extent::Texts } else { Extent::Disk });
        }
        self.checker.want_newer();
        self.check_at = pause.map(|pause| Instant::now() + pause);
        self.settle();
    }

    /// The checks that read a file, or may read it now.
    pub(super) fn scopes_of(&self, path: &Path) -> Vec<Scope> {
        let folders = self.folders.iter().map(|folder| Scope::Folder(folder.clone()));
        let scopes = folders.chain((!self.elsewhere.is_empty()).then_some(Scope::Elsewhere));
        let reads = |scope: &Scope| {
            let is_below = matches!(scope, Scope::Folder(folder) if path.starts_with(folder) || is_above(path, folder));
            let mut directories = self.elsewhere.iter().filter_map(|file| file.parent());
            let is_beside = *scope == Scope::Elsewhere
                && (!is_rust(path) || directories.any(|directory| path.starts_with(directory)));
            is_below || is_beside || self.units.get(scope).is_some_and(|unit| unit.reads(path))
        };
        scopes.filter(reads).collect()
    }

    pub(super) fn recheck(&mut self, scope: Scope, extent: Extent) {
        self.offered = None;
        let known = self.stale.entry(scope).or_default();
        *known = extent.max(*known);
    }

    /// Checks a file once more, for the guards that can be offered for its loops: few look at that, and it takes time at each edit.
    fn make_offers(&mut self, file: Option<PathBuf>) {
        let scopes = file.as_ref().map(|file| self.scopes_of(file));
        for scope in scopes.into_iter().flatten() {
            self.recheck(scope, Extent::Texts);
        }
        self.offered = file;
    }

    pub(super) fn recheck_all(&mut self, extent: Extent) {
        let folders: Vec<Scope> = self.folders.iter().cloned().map(Scope::Folder).collect();
        for scope in folders.into_iter().chain((!self.elsewhere.is_empty()).then_some(Scope::Elsewhere)) {
            self.recheck(scope, extent);
        }
        self.checker.want_newer();
    }

    /// Whether what is known is known of the code as it is.
    pub(super) fn is_settled(&self) -> bool {
        self.stale.is_empty() && !self.is_checking
    }

    /// Starts the check of what is stale, when it is time.
    pub(super) fn start_check(&mut self) {
        if self.is_checking || self.stale.is_empty() || self.phase != Phase::Ready || !self.is_introduced {
            return;
        }
        let is_early = self.check_at.is_some_and(|at| Instant::now() < at);
        // Whoever asks does not want to wait for a pause.
        if is_early && self.waiting.is_empty() {
            return;
        }
        self.check_at = None;
        let files = |scope: &Scope| if *scope == Scope::Elsewhere { self.elsewhere.clone() } else { Vec::new() };
        let tasks = std::mem::take(&mut self.stale).into_iter().map(|(scope, extent)| Task {
            files: files(&scope),
            scope,
            extent,
            offered: self.offered.clone(),
            settings: self.settings.clone(),
        });
        let tasks = tasks.collect();
        let buffers = self.documents.iter().map(|(path, document)| (path.clone(), Arc::clone(&document.text)));
        self.is_checking = true;
        self.checker.give(Job { state: self.checker.wanted(), tasks, buffers: buffers.collect() });
    }

    /// Takes in what a check has found.
    pub(super) fn learn(&mut self, checked: Checked) {
        self.is_checking = false;
        for task in checked.dropped {
            if self.is_known(&task.scope) {
                self.recheck(task.scope, task.extent);
            }
        }
        for (scope, outcome) in checked.finished {
            // What has changed since is checked again.
            if !self.stale.contains_key(&scope) && self.is_known(&scope) {
                let unit = self.unit(&scope, outcome);
                self.units.insert(scope, unit);
            }
        }
        self.settle();
    }

    fn is_known(&self, scope: &Scope) -> bool {
        match scope {
            Scope::Folder(folder) => self.folders.contains(folder),
            Scope::Elsewhere => !self.elsewhere.is_empty(),
        }
    }

    fn unit(&self, scope: &Scope, outcome: Outcome) -> Unit {
        match outcome {
            Outcome::Checked(judged) => {
                for notice in &judged.notices {
                    self.log(2, notice);
                }
                let root = &judged.project.root;
                Unit::of_judged(&judged, self.units.get(scope), |report| {
                    let diagnostics = findings::of_report(report, root, &self.client, &self.documents);
                    Part::new(Arc::clone(report), diagnostics)
                })
            }
            Outcome::Nothing => Unit::default(),
            Outcome::NotLoaded { message } => {
                self.log(1, &message);
                let mut diagnostics = BTreeMap::new();
                if let Scope::Folder(folder) = scope {
                    let manifests = folder.ancestors().map(|directory| directory.join("Cargo.toml"));
                    let manifest = manifests.into_iter().find(|manifest| manifest.is_file());
                    let error = findings::of_whole_file(message);
                    diagnostics.extend(manifest.map(|manifest| (identity(&manifest), vec![error])));
                }
                Unit::failed(diagnostics)
            }
            Outcome::Panicked { message } => {
                self.log_bug(&message);
                Unit::failed(BTreeMap::new())
            }
        }
    }

    /// When nothing is left to be checked: tells what was found, and answers what was asked.
    pub(super) fn settle(&mut self) {
        if self.phase != Phase::Ready || !self.is_settled() {
            return;
        }
        let elsewhere = self.uncovered();
        if elsewhere != self.elsewhere {
            self.elsewhere = elsewhere;
            self.units.remove(&Scope::Elsewhere);
            if !self.elsewhere.is_empty() {
                self.recheck(Scope::Elsewhere, Extent::Disk);
                return;
            }
        }
        let changed = self.units.take_changed();
        self.publish(&changed);
        for (id, question) in std::mem::take(&mut self.waiting) {
            if self.lacks_offers(&question) {
                self.waiting.push((id, question));
                continue;
            }
            let answer = self.answer_or_bug(&question);
            self.answer(&id, answer);
        }
        if let Some((_, question)) = self.waiting.first() {
            self.make_offers(question.path(&self.documents));
        }
        self.refresh(&changed);
        match std::mem::replace(&mut self.progress, Progress::Over) {
            Progress::Shown => self.end_progress(),
            Progress::Due | Progress::Over => {}
        }
    }

    /// The open Rust files on the disk that no folder's check reads.
    fn uncovered(&self) -> Vec<PathBuf> {
        let is_covered = |path: &Path| {
            self.units.iter().any(|(scope, unit)| match scope {
                Scope::Elsewhere => false,
                // What could not be checked with its folder cannot be checked alone.
                Scope::Folder(folder) => unit.covers(path) || (unit.is_failed && path.starts_with(folder)),
            })
        };
        let paths = self.documents.iter().map(|(path, _)| path);
        paths.filter(|path| is_rust(path) && path.is_file() && !is_covered(path)).cloned().collect()
    }
}

pub(super) fn is_rust(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "rs")
}

/// Whether a manifest or a configuration file stands in a directory above a folder.
fn is_above(path: &Path, folder: &Path) -> bool {
    !is_rust(path) && path.parent().is_some_and(|directory| folder.starts_with(directory))
}
