//! A module with its names.

use rustc_hash::{FxHashMap, FxHashSet};

use super::{CrateId, Def, ModuleId, Namespace};
use crate::source::FileId;

/// A module, or a block with items of its own.
#[derive(Debug)]
pub struct Module {
    /// Its crate.
    pub krate: CrateId,
    /// The module around it.
    pub parent: Option<ModuleId>,
    /// Its name; empty for a crate root or a block.
    pub name: String,
    /// Whether it is a block: names that are not found in it are looked up around it.
    pub is_block: bool,
    /// Whether it is compiled for tests only.
    pub is_test: bool,
    /// Whether it stands without any `pub`.
    pub is_private: bool,
    /// Where its items stand; none for a module without items.
    pub file: Option<FileId>,
    pub(super) names: FxHashMap<(Namespace, String), Entry>,
    pub(super) globs: Vec<Vec<String>>,
    /// What is imported under a name that something else has already: `as _`, or under another `cfg`.
    pub(super) unnamed: Vec<Vec<String>>,
    /// The names of imports and traits that stand without any `pub`.
    pub(super) private: FxHashSet<String>,
}

impl Module {
    /// A module without names, that of a whole crate where there is none around it.
    pub(super) fn of(krate: CrateId, parent: Option<ModuleId>) -> Self {
        Self {
            krate,
            parent,
            name: String::new(),
            is_block: false,
            is_test: false,
            is_private: false,
            file: None,
            names: FxHashMap::default(),
            globs: Vec::new(),
            unnamed: Vec::new(),
            private: FxHashSet::default(),
        }
    }
}

#[derive(Clone, Debug)]
pub(super) enum Entry {
    Def(Def),
    Import(Vec<String>),
}
