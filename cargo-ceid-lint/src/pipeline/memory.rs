//! What a check leaves for the next one of the same project, when since then only texts that an editor holds have changed. What
//! reads none of them is as it was; of the rest, unchanged packages are not parsed again.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use super::parse::Part;
use super::{Named, Report};
use crate::config::Config;
use crate::project::{Manners, Project};
use crate::relevance::Component;
use crate::source::ReadSource;

/// How much code is kept as trees, in bytes: a tree takes some forty times as much.
const MOST_KEPT: u64 = 4 * 1024 * 1024;

/// The results of a check, by what they were made of.
#[derive(Debug, Default)]
pub struct Memory {
    /// The configuration.
    config: Option<Arc<Config>>,
    manners: Arc<KnownManners>,
    /// The texts that were held in place of the disk's.
    held: BTreeMap<PathBuf, Arc<str>>,
    /// What the disk says of the packages, and which of them are open.
    components: Option<Vec<Component>>,
    judged: Vec<Arc<Judged>>,
    /// The packages that were judged.
    packages: BTreeSet<usize>,
    trees: BTreeMap<usize, Part>,
}

/// What is asked of the code in files, which takes reading several others.
#[derive(Debug, Default)]
pub(super) struct KnownManners(Mutex<BTreeMap<PathBuf, Manners>>);

impl KnownManners {
    /// What is asked of the code in a file of the project.
    pub(super) fn of(&self, project: &Project, path: &Path) -> Manners {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        *known.entry(path.to_owned()).or_insert_with(|| project.manners(path))
    }
}

/// Packages that were analysed together.
#[derive(Debug)]
pub(super) struct Judged {
    pub(super) packages: Vec<usize>,
    /// The files that were read.
    pub(super) read: BTreeSet<PathBuf>,
    pub(super) can_matter: bool,
    pub(super) report: Arc<Report>,
    pub(super) named: Named,
}

impl Memory {
    /// Forgets everything: the disk may be another one, or a check has not seen all of it.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    /// Forgets what was found in a file and in what was checked with it, but not what was read.
    pub fn forget_checked_with(&mut self, file: &Path) {
        self.judged.retain(|own| !own.read.contains(file));
    }

    /// The configuration, if no text that is held can be a part of it.
    pub(super) fn config(&self, source: &dyn ReadSource) -> Option<Arc<Config>> {
        let is_code = |path: PathBuf| path.extension().is_some_and(|extension| extension == "rs");
        self.config.clone().filter(|_| source.held().into_iter().all(is_code))
    }

    /// Takes in a configuration that was read, and forgets what was found with another one.
    pub(super) fn learn_config(&mut self, config: &Arc<Config>) {
        let is_same = |own: &Arc<Config>| format!("{own:?}") == format!("{config:?}");
        if !self.config.as_ref().is_some_and(is_same) {
            self.forget();
        }
        self.config = Some(Arc::clone(config));
    }

    /// Takes in what the next check is made on, and forgets what that makes wrong.
    pub(super) fn prepare(&mut self, source: &dyn ReadSource) {
        let held: BTreeMap<PathBuf, Arc<str>> =
            source.held().into_iter().filter_map(|path| Some((path.clone(), source.read(&path).ok()?))).collect();
        if !held.keys().eq(self.held.keys()) {
            *self = Self { config: self.config.take(), ..Self::default() };
        }
        let is_same = |path: &PathBuf| held.get(path) == self.held.get(path);
        let is_unchanged = |read: &BTreeSet<PathBuf>| held.keys().all(|path| is_same(path) || !read.contains(path));
        self.judged.retain(|own| is_unchanged(&own.read));
        self.packages = self.judged.iter().flat_map(|own| own.packages.iter().copied()).collect();
        self.trees.retain(|_, part| is_unchanged(&part.read));
        self.held = held;
    }

    /// What was found out of the packages, if that is known. It is lent for the time of a check.
    pub(super) fn take_components(&mut self) -> Option<Vec<Component>> {
        self.components.take()
    }

    pub(super) fn learn_components(&mut self, components: Vec<Component>) {
        self.components = Some(components);
    }

    /// What is asked of the code in files.
    pub(super) fn manners(&self) -> Arc<KnownManners> {
        Arc::clone(&self.manners)
    }

    /// What was found in the packages, if it still holds.
    pub(super) fn has_judged(&self, package: usize) -> bool {
        self.packages.contains(&package)
    }

    /// Whether one of these files was read for what still holds: then it has to do with what is parsed now.
    pub(super) fn have_read(&self, parts: &[Part]) -> bool {
        parts.iter().flat_map(|part| &part.read).any(|file| self.judged.iter().any(|own| own.read.contains(file)))
    }

    pub(super) fn judged(&self) -> &[Arc<Judged>] {
        &self.judged
    }

    pub(super) fn learn_judged(&mut self, judged: Vec<Arc<Judged>>) {
        self.judged = judged;
    }

    /// The parsed package, if it still holds.
    pub(super) fn tree(&self, package: usize) -> Option<Part> {
        self.trees.get(&package).cloned()
    }

    /// Keeps parsed packages, as long as there is room.
    pub(super) fn learn_tree(&mut self, package: usize, part: &Part) {
        let kept: u64 = self.trees.values().map(Part::bytes_read).sum();
        if !self.trees.contains_key(&package) && kept + part.bytes_read() <= MOST_KEPT {
            self.trees.insert(package, part.clone());
        }
    }
}
