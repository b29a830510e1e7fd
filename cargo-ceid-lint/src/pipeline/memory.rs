//! What a check leaves for the next one of the same project, when since then only texts that an editor holds have changed. What
//! reads none of them is as it was; of the rest, unchanged packages are not parsed again.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

use super::parse::Part;
use super::{Named, Report};
use crate::config::Config;
use crate::relevance::Component;
use crate::source::ReadSource;

/// How much code is kept as trees, in bytes: a tree takes some forty times as much.
const MOST_KEPT: u64 = 4 * 1024 * 1024;

/// The results of a check, by what they were made of.
#[derive(Debug, Default)]
pub struct Memory {
    /// The configuration in full.
    config: String,
    /// The texts that were held in place of the disk's.
    held: BTreeMap<PathBuf, Arc<str>>,
    /// What the disk says of the packages.
    components: Option<Vec<Component>>,
    judged: Vec<Arc<Judged>>,
    /// The packages that were judged.
    packages: BTreeSet<usize>,
    trees: BTreeMap<usize, Part>,
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

    /// Takes in what the next check is made on, and forgets what that makes wrong.
    pub(super) fn prepare(&mut self, config: &Config, source: &dyn ReadSource) {
        let config = format!("{config:?}");
        let held: BTreeMap<PathBuf, Arc<str>> =
            source.held().into_iter().filter_map(|path| Some((path.clone(), source.read(&path).ok()?))).collect();
        if config != self.config || !held.keys().eq(self.held.keys()) {
            self.forget();
            self.config = config;
        }
        let is_same = |path: &PathBuf| held.get(path) == self.held.get(path);
        let is_unchanged = |read: &BTreeSet<PathBuf>| held.keys().all(|path| is_same(path) || !read.contains(path));
        self.judged.retain(|own| is_unchanged(&own.read));
        self.packages = self.judged.iter().flat_map(|own| own.packages.iter().copied()).collect();
        self.trees.retain(|_, part| is_unchanged(&part.read));
        self.held = held;
    }

    /// What the disk says of the packages, if that is known.
    pub(super) fn components(&self) -> Option<Vec<Component>> {
        self.components.clone()
    }

    pub(super) fn learn_components(&mut self, components: &[Component]) {
        self.components = Some(components.to_vec());
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
