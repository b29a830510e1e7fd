//! Under which names the files of a crate know other crates, and what they import from them.

use std::collections::{BTreeMap, BTreeSet};

use super::{Neighbours, has_known_macros};
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
    /// The macros that are imported by name from crates that are read, under the names that they get: of which crate, and how they
    /// are called there. Two files may have different ones.
    of_neighbours: BTreeMap<String, Option<(String, String)>>,
    /// Crates that are read of which all macros, or all of a module, are imported.
    whole_neighbours: BTreeSet<String>,
}

impl Imported {
    /// Adds the imports of a file.
    pub(in crate::syntax) fn note(&mut self, items: &[syn::Item], neighbours: &Neighbours) {
        for item in items {
            if !neighbours.exports.is_empty() {
                self.note_neighbours(item, neighbours);
            }
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
                    self.note(content.as_ref().map_or(&[], |(_, items)| items), neighbours);
                }
                _ => {}
            }
        }
    }

    fn note_neighbours(&mut self, item: &syn::Item, neighbours: &Neighbours) {
        match item {
            syn::Item::ExternCrate(item)
                if item.attrs.iter().any(|attribute| attribute.path().is_ident("macro_use")) =>
            {
                self.whole_neighbours.insert(name(&item.ident));
            }
            syn::Item::Use(item) => {
                let mut open = vec![(None, &item.tree)];
                while let Some((home, tree)) = open.pop() {
                    let (own, local) = match tree {
                        syn::UseTree::Path(path) => {
                            open.push((Some(home.unwrap_or_else(|| name(&path.ident))), &path.tree));
                            continue;
                        }
                        syn::UseTree::Group(group) => {
                            open.extend(group.items.iter().map(|tree| (home.clone(), tree)));
                            continue;
                        }
                        syn::UseTree::Glob(_) => {
                            self.whole_neighbours.extend(home);
                            continue;
                        }
                        syn::UseTree::Name(tree) => (name(&tree.ident), name(&tree.ident)),
                        syn::UseTree::Rename(tree) => (name(&tree.ident), name(&tree.rename)),
                    };
                    let Some(home) = home.filter(|home| is_given_by(neighbours, home, &own)) else { continue };
                    let from = Some((home, own));
                    let known = self.of_neighbours.entry(local).or_insert_with(|| from.clone());
                    if *known != from {
                        *known = None;
                    }
                }
            }
            _ => {}
        }
    }

    /// The crate that a macro without a path is of, with its name there.
    pub(super) fn of_neighbour<'i>(&'i self, name: &'i str, neighbours: &Neighbours) -> Option<(&'i str, &'i str)> {
        if self.is_of_neighbour(name) {
            return self.of_neighbours[name].as_ref().map(|(home, own)| (home.as_str(), own.as_str()));
        }
        // A known one is more likely to be meant than one that comes with all others.
        let mut homes = self.whole_neighbours.iter().filter(|home| is_given_by(neighbours, home, name));
        let home = homes.next().filter(|_| super::shape(name).is_none())?;
        homes.next().is_none().then_some((home, name))
    }

    /// Whether a macro is imported by its name from a crate that is read, and in no file from one whose macros are known.
    pub(super) fn is_of_neighbour(&self, name: &str) -> bool {
        self.of_neighbours.contains_key(name) && !self.of_known.contains(name)
    }

    /// Whether the crate has a module of that name.
    pub(super) fn is_module(&self, name: &str) -> bool {
        self.modules.contains(name)
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

fn is_given_by(neighbours: &Neighbours, home: &str, macro_name: &str) -> bool {
    neighbours.exports.get(home).is_some_and(|exports| exports.has(macro_name))
}
