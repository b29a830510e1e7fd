//! Under which names the files of a crate know other crates, and what they import from them.

use std::collections::BTreeSet;

use super::has_known_macros;
use crate::syntax::lower::name;

/// Crates whose macros have names that others may have as well: `array!`, `point!`.
const OF_COMMON_NAMES: &[&str] = &["nalgebra", "ndarray"];

/// What the imports of the files say that were met so far.
#[derive(Default)]
pub(in crate::syntax) struct Imported {
    /// Other names of crates whose macros are known.
    crates: BTreeSet<String>,
    /// What is imported from the crates with common names.
    names: BTreeSet<String>,
    /// Whether all of such a crate, or of a module of it, is imported.
    is_all: bool,
}

impl Imported {
    /// Adds the imports of a file.
    pub(in crate::syntax) fn note(&mut self, items: &[syn::Item]) {
        for item in items {
            match item {
                syn::Item::ExternCrate(syn::ItemExternCrate { ident, rename: Some((_, alias)), .. }) => {
                    self.rename(ident, alias);
                }
                syn::Item::Use(item) => match &item.tree {
                    syn::UseTree::Rename(tree) => self.rename(&tree.ident, &tree.rename),
                    syn::UseTree::Path(path) if self.has_common_names(&name(&path.ident)) => {
                        self.names_of(&path.tree);
                    }
                    _ => {}
                },
                _ => {}
            }
        }
    }

    fn has_common_names(&self, name: &str) -> bool {
        OF_COMMON_NAMES.contains(&name) || self.crates.contains(name)
    }

    fn rename(&mut self, of: &syn::Ident, alias: &syn::Ident) {
        if has_known_macros(&name(of)) {
            self.crates.insert(name(alias));
        }
    }

    fn names_of(&mut self, tree: &syn::UseTree) {
        match tree {
            syn::UseTree::Path(path) => self.names_of(&path.tree),
            syn::UseTree::Name(tree) => {
                self.names.insert(name(&tree.ident));
            }
            syn::UseTree::Group(group) => group.items.iter().for_each(|tree| self.names_of(tree)),
            syn::UseTree::Glob(_) => self.is_all = true,
            syn::UseTree::Rename(_) => {}
        }
    }

    /// Whether `use` gives that name to a crate whose macros are known.
    pub(super) fn is_crate(&self, name: &str) -> bool {
        self.crates.contains(name)
    }

    /// Whether a macro of a common name may be imported.
    pub(super) fn has(&self, name: &str) -> bool {
        self.is_all || self.names.contains(name)
    }
}
