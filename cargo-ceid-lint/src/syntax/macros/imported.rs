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
    /// What a `use` of one name gives on, as macros of the crate are: `pub(crate) use info;`.
    given_on: BTreeSet<String>,
    /// The modules of the crate.
    modules: BTreeSet<String>,
    /// What is imported by its name from crates whose macros are known: `use log::info;`.
    of_known: BTreeSet<String>,
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
                    syn::UseTree::Path(path) => {
                        let of = name(&path.ident);
                        if self.has_common_names(&of) {
                            self.names_of(&path.tree);
                        }
                        if has_known_macros(&of) || self.crates.contains(&of) {
                            each_name(&path.tree, &mut |ident| {
                                self.of_known.insert(name(ident));
                            });
                        }
                    }
                    tree => each_name(tree, &mut |ident| {
                        self.given_on.insert(name(ident));
                    }),
                },
                syn::Item::Mod(syn::ItemMod { ident, content, .. }) => {
                    self.modules.insert(name(ident));
                    self.note(content.as_ref().map_or(&[], |(_, items)| items));
                }
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

    /// Whether a macro of the crate is given on under its name, and no other one of that name is imported.
    pub(super) fn is_given_on(&self, name: &str) -> bool {
        self.given_on.contains(name) && !self.of_known.contains(name)
    }

    /// Whether a module of the crate gives a macro on: `filters::declare!(…)` beside `pub(crate) use declare;`.
    pub(super) fn is_given_on_by(&self, module: &str, name: &str) -> bool {
        self.modules.contains(module) && self.given_on.contains(name)
    }

    /// Whether a macro of a common name may be imported.
    pub(super) fn has(&self, name: &str) -> bool {
        self.is_all || self.names.contains(name)
    }
}

/// The names at the ends of a `use`, but for other names that it gives.
fn each_name(tree: &syn::UseTree, found: &mut dyn FnMut(&syn::Ident)) {
    match tree {
        syn::UseTree::Path(path) => each_name(&path.tree, found),
        syn::UseTree::Name(tree) => found(&tree.ident),
        syn::UseTree::Group(group) => group.items.iter().for_each(|tree| each_name(tree, found)),
        syn::UseTree::Rename(_) | syn::UseTree::Glob(_) => {}
    }
}
