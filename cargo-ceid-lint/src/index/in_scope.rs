//! Which traits are in scope in a module, so that their methods can be called there by name.

use rustc_hash::FxHashSet;

use super::names::Trail;
use super::{Def, Entry, Index, ModuleId, Namespace, TraitName, known};

/// The name of what has none: `use trait as _`.
const UNNAMED: &str = "_";

/// Under which names a module has a trait.
#[derive(Debug, Default)]
struct Named {
    names: Vec<String>,
    /// Whether there may be more, which is not seen.
    is_unsure: bool,
}

impl Index {
    /// Whether a trait is in scope in a module; `None` if that cannot be told.
    #[must_use]
    pub fn is_in_scope(&self, module: ModuleId, name: &TraitName) -> Option<bool> {
        let key = (module, name.clone());
        if let Some(known) = self.in_scope.read().ok().and_then(|known| known.get(&key).copied()) {
            return known;
        }
        let found = self.find_in_scope(module, name);
        if let Ok(mut known) = self.in_scope.write() {
            known.insert(key, found);
        }
        found
    }

    fn find_in_scope(&self, module: ModuleId, name: &TraitName) -> Option<bool> {
        let mut is_unsure = false;
        let mut scope = Some(module);
        while let Some(at) = scope {
            let named = self.named_in(at, name, &mut FxHashSet::default());
            if !named.names.is_empty() {
                return Some(true);
            }
            is_unsure |= named.is_unsure;
            // A block sees what is around it, a module does not.
            scope = if self.module(at).is_block { self.module(at).parent } else { None };
        }
        match name {
            TraitName::External(path) => {
                let last = path.rsplit("::").next().unwrap_or_default();
                (known::prelude(last) == Some(path.as_str())).then_some(true)
            }
            TraitName::Local(_) => (!is_unsure).then_some(false),
        }
    }

    fn named_in(&self, at: ModuleId, name: &TraitName, seen: &mut FxHashSet<ModuleId>) -> Named {
        let mut found = Named::default();
        if !seen.insert(at) {
            return found;
        }
        let module = self.module(at);
        // What a macro makes that is not read may be an import.
        found.is_unsure = self.opaque_items.iter().any(|(of, _)| *of == at);
        let is_unsure = &mut found.is_unsure;
        let own = module.names.iter().filter(|((namespace, _), entry)| match entry {
            Entry::Def(def) => *namespace == Namespace::Type && is_trait(def, name),
            Entry::Import(path) => *namespace == Namespace::Type && self.imports_trait(at, path, name, is_unsure),
        });
        found.names.extend(own.map(|((_, own), _)| own.clone()));
        for path in &module.unnamed {
            if self.imports_trait(at, path, name, &mut found.is_unsure) {
                found.names.push(UNNAMED.to_owned());
            }
        }
        for glob in &module.globs {
            let target = match self.resolve_import(at, glob, Namespace::Type, &mut Trail::default()) {
                Some(Def::Module(target)) => target,
                // A crate that is not read has no trait of one that is.
                Some(Def::External(_)) => {
                    found.is_unsure |= matches!(name, TraitName::External(_));
                    continue;
                }
                Some(_) => continue,
                None => {
                    found.is_unsure = true;
                    continue;
                }
            };
            let sees_private = self.lies_in(at, target);
            let globbed = self.named_in(target, name, seen);
            found.is_unsure |= globbed.is_unsure;
            for own in globbed.names {
                // What a module names itself, no glob brings in.
                let is_hidden = module.names.contains_key(&(Namespace::Type, own.clone())) && own != UNNAMED;
                let is_private = !sees_private && self.module(target).private.contains(&own);
                // Of what has no name, it is not told apart what is private.
                found.is_unsure |= is_private && own == UNNAMED;
                if !is_hidden && !is_private {
                    found.names.push(own);
                }
            }
        }
        found
    }

    /// Whether an import is one of a trait; notes what cannot be told.
    fn imports_trait(&self, at: ModuleId, path: &[String], name: &TraitName, is_unsure: &mut bool) -> bool {
        // No trait is called as functions and macros are.
        let may_be_trait = path.last().is_some_and(|last| !last.starts_with(char::is_lowercase));
        let target = self.resolve_import(at, path, Namespace::Type, &mut Trail::default());
        *is_unsure |= target.is_none() && may_be_trait;
        target.is_some_and(|def| is_trait(&def, name))
    }

    /// Whether a module is another one or lies in it.
    fn lies_in(&self, module: ModuleId, outer: ModuleId) -> bool {
        let mut at = Some(module);
        while let Some(own) = at.filter(|own| *own != outer) {
            at = self.module(own).parent;
        }
        at.is_some()
    }
}

fn is_trait(def: &Def, name: &TraitName) -> bool {
    match (def, name) {
        (Def::Trait(id), TraitName::Local(own)) => id == own,
        (Def::External(path), TraitName::External(own)) => path == own,
        _ => false,
    }
}
