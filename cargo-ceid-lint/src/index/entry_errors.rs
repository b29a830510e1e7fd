//! What an entry does not name: the error, with its place and the nearest right spelling.

use std::collections::BTreeSet;

use super::entries::EntryScope;
use super::possible::may_define;
use super::{Def, Index, ModuleId, Namespace, Owner, TraitName, TypeId};
use crate::config::spelling::nearest;
use crate::config::{ConfigError, FilterTarget, GuardEntry, Word};
use crate::syntax::tree::OpaqueMacro;

/// An error for an entry about the standard library, all of whose types would be filters.
pub(super) fn is_of_std(word: &Word) -> ConfigError {
    let message = format!("`{}` is of the standard library, which has no filters", word.text);
    ConfigError::at(word.place.clone(), message).help("name the type or the trait that has the update law")
}

impl Index {
    /// An error for a path that names a thing of another kind.
    pub(super) fn is_something_else(&self, word: &Word, def: &Def, target: &FilterTarget) -> ConfigError {
        let wanted = match target {
            FilterTarget::Type(_) => "a type",
            FilterTarget::Trait(_) => "a trait",
            FilterTarget::Function(_) => "a function",
        };
        let message = format!("`{}` is {}, not {wanted}", word.text, described(def));
        let error = ConfigError::at(word.place.clone(), message);
        match def {
            Def::Type(_) => error.help(format!("write `type = \"{}\"`", word.text)),
            Def::Trait(_) => error.help(format!("write `trait = \"{}\"`", word.text)),
            Def::Function(_) => error.help(format!("write `function = \"{}\"`", word.text)),
            _ => error,
        }
    }

    /// An error for a path that names a thing which nothing calls.
    pub(super) fn is_no_function(&self, word: &Word, def: &Def) -> ConfigError {
        let error =
            ConfigError::at(word.place.clone(), format!("`{}` is {}, not a function", word.text, described(def)));
        match self.method_names(def).first() {
            Some(method) => error.help(format!("name a function or a method, as in `{}::{method}`", word.text)),
            None => error.help("name a function or a method"),
        }
    }

    /// Whether a part of the path is the name of something that this build leaves out.
    pub(super) fn is_removed(&self, scope: &EntryScope<'_>, path: &str) -> bool {
        scope.crates.iter().any(|krate| path.split("::").any(|name| self.crate_info(*krate).removed.contains(name)))
    }

    pub(super) fn names_nothing(&self, scope: &EntryScope<'_>, word: &Word, wanted: &str) -> ConfigError {
        let error = ConfigError::at(word.place.clone(), format!("`{}` names nothing", word.text));
        let (first, last) = (word.text.split("::").next().unwrap_or_default(), last(&word.text));
        if first != word.text && !self.is_crate_name(scope, first) {
            let names: BTreeSet<&str> = scope
                .crates
                .iter()
                .map(|krate| self.crate_info(*krate))
                .flat_map(|info| info.externs.keys().map(String::as_str).chain([info.name.as_str()]))
                .collect();
            return match nearest(first, names) {
                Some(name) => error.help(format!("did you mean `{name}{}`?", &word.text[first.len()..])),
                None => error.help(format!(
                    "`{first}` is neither a member of the workspace nor a dependency; `crate::` begins a path in a member"
                )),
            };
        }
        // A path begins in a crate.
        let first = if self.is_crate_name(scope, first) { first } else { "crate" };
        let paths = self.paths_of(scope, first, wanted);
        let same = paths.iter().find(|path| self::last(path) == last);
        let near = || {
            let name = nearest(last, paths.iter().map(|path| self::last(path)))?;
            paths.iter().find(|path| self::last(path) == name)
        };
        match same.or_else(near) {
            Some(path) => error.help(format!("did you mean `{path}`?")),
            None => error.help(format!("there is no {wanted} of that name in the code that was read")),
        }
    }

    /// The paths of all items of a kind, beginning as the user began.
    pub(super) fn paths_of(&self, scope: &EntryScope<'_>, first: &str, wanted: &str) -> Vec<String> {
        let of_type = self.types.iter().map(|def| (def.module, &def.name));
        let of_trait = self.traits.iter().map(|def| (def.module, &def.name));
        let functions = self.functions.iter().filter(|def| def.owner == Owner::Module);
        let of_function = functions.map(|def| (def.module, &def.name));
        let all: Vec<(ModuleId, &String)> = match wanted {
            "type" => of_type.collect(),
            "trait" => of_trait.collect(),
            _ => of_function.collect(),
        };
        all.into_iter()
            .filter(|(module, _)| {
                let krate = self.module(*module).krate;
                scope.crates.contains(&krate) && !self.module(*module).is_block
            })
            .map(|(module, name)| {
                let mut parts = vec![name.clone()];
                let mut at = Some(module);
                while let Some(module) = at {
                    let module = self.module(module);
                    if module.parent.is_some() {
                        parts.push(module.name.clone());
                    }
                    at = module.parent;
                }
                parts.push(first.to_owned());
                parts.reverse();
                parts.join("::")
            })
            .collect()
    }

    /// Whether a type or trait may have a method: it has it, or code that could have it is not read.
    pub(super) fn may_have_method(&self, scope: &EntryScope<'_>, def: &Def, method: &Word) -> bool {
        scope.is_partial || self.is_removed(scope, &method.text) || self.has_method(def, &method.text) != Some(false)
    }

    /// An error if the type or trait certainly has no such method.
    pub(super) fn check_method(
        &self,
        scope: &EntryScope<'_>,
        def: &Def,
        owner: &Word,
        method: &Word,
    ) -> Result<(), ConfigError> {
        if self.may_have_method(scope, def, method) {
            return Ok(());
        }
        let error = self.has_no_method(def, &owner.text, method);
        if nearest(&method.text, self.method_names(def)).is_none()
            && let Some(path) = self.other_owner(scope, owner, &method.text)
        {
            return Err(error.help(format!("`{path}` has it: an entry names the type of which the law is a method")));
        }
        Err(error)
    }

    /// An error if what gives the guard of an entry is neither one of its methods nor a function.
    pub(super) fn check_register(
        &self,
        scope: &EntryScope<'_>,
        def: &Def,
        entry: &GuardEntry,
    ) -> Result<(), ConfigError> {
        let word = &entry.register;
        let is_function = self.functions.iter().any(|own| {
            let is_free = own.owner == Owner::Module && own.name == word.text;
            is_free && scope.crates.contains(&self.module(own.module).krate)
        });
        if is_function { Ok(()) } else { self.check_method(scope, def, &entry.guard_type, word) }
    }

    pub(super) fn has_no_method(&self, def: &Def, owner: &str, method: &Word) -> ConfigError {
        let message = format!("`{owner}` has no method `{}`", method.text);
        let error = ConfigError::at(method.place.clone(), message);
        let names = self.method_names(def);
        match nearest(&method.text, names.iter().copied()) {
            Some(name) => error.help(format!("did you mean `{name}`?")),
            None if names.is_empty() => error,
            None => {
                let list: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
                error.help(format!("it has {}", list.join(", ")))
            }
        }
    }

    /// The path of the only type that has a method of that name: a law that takes its state as an argument is one of another type.
    fn other_owner(&self, scope: &EntryScope<'_>, owner: &Word, method: &str) -> Option<String> {
        let is_in_scope = |module: ModuleId| scope.crates.contains(&self.module(module).krate);
        let types = (0u32..).zip(&self.types).filter(|(_, def)| is_in_scope(def.module));
        let mut owners = types.filter(|(number, _)| self.method_names(&Def::Type(TypeId(*number))).contains(method));
        let (_, only) = owners.next()?;
        if owners.next().is_some() {
            return None;
        }
        let first = owner.text.split("::").next().unwrap_or_default();
        self.paths_of(scope, first, "type").into_iter().find(|path| last(path) == only.name)
    }

    /// Whether a type or trait has a method; `None` if it may have methods that cannot be seen.
    pub(super) fn has_method(&self, def: &Def, name: &str) -> Option<bool> {
        if self.method_names(def).contains(name) {
            return Some(true);
        }
        let is_unseen = |of: &TraitName| matches!(of, TraitName::External(path) if !is_without_methods(path));
        let (module, is_open) = match def {
            Def::Type(id) => {
                let impls = self.impls_of(&self.bare(*id));
                let implemented = impls.iter().filter_map(|id| self.impl_def(*id).implements.as_ref());
                (self.type_def(*id).module, implemented.clone().any(is_unseen))
            }
            Def::Trait(id) => {
                let of = self.trait_def(*id);
                let scope = self.scope(of.module, Owner::Module, Some(&of.generics));
                let supertraits = self.lower_bounds(&of.supertraits, &scope, 0);
                (of.module, supertraits.iter().any(|bound| is_unseen(&bound.name)))
            }
            _ => return None,
        };
        let krate = self.module(module).krate;
        let names = self.names_of(def);
        let is_made = |(at, call): &(ModuleId, OpaqueMacro)| {
            self.module(*at).krate == krate && names.iter().any(|name| may_define(call, [name, name]))
        };
        if is_open || self.opaque_items.iter().any(is_made) { None } else { Some(false) }
    }

    /// The names of a type or trait, others that modules give it among them.
    fn names_of(&self, def: &Def) -> BTreeSet<&str> {
        let means_it = |module: usize, name: &String| {
            let module = ModuleId(u32::try_from(module).unwrap_or(u32::MAX));
            let found = self.resolve(module, std::slice::from_ref(name), Namespace::Type);
            found.and_then(|found| self.behind_alias(found)).as_ref() == Some(def)
        };
        let names = self.modules.iter().enumerate().flat_map(|(module, of)| {
            of.names.keys().filter(|(namespace, _)| *namespace == Namespace::Type).map(move |(_, name)| (module, name))
        });
        names.filter(|(module, name)| means_it(*module, name)).map(|(_, name)| name.as_str()).collect()
    }

    /// The functions and methods that a type or trait is seen to have.
    fn method_names(&self, def: &Def) -> BTreeSet<&str> {
        let of_trait = |id: super::TraitId| {
            let mut names: BTreeSet<&str> = BTreeSet::new();
            let (mut open, mut done) = (vec![id], BTreeSet::new());
            while let Some(id) = open.pop() {
                if !done.insert(id) {
                    continue;
                }
                let def = self.trait_def(id);
                names.extend(def.methods.keys().map(String::as_str));
                let scope = self.scope(def.module, Owner::Module, Some(&def.generics));
                for bound in self.lower_bounds(&def.supertraits, &scope, 0) {
                    if let TraitName::Local(id) = bound.name {
                        open.push(id);
                    }
                }
            }
            names
        };
        match def {
            Def::Type(id) => {
                let mut names = BTreeSet::new();
                for id in self.impls_of(&self.bare(*id)) {
                    let def = self.impl_def(id);
                    names.extend(def.methods.keys().map(String::as_str));
                    if let Some(TraitName::Local(id)) = &def.implements {
                        names.extend(of_trait(*id));
                    }
                }
                names
            }
            Def::Trait(id) => of_trait(*id),
            _ => BTreeSet::new(),
        }
    }
}

/// The same error, of which the correction goes on with the method that was named.
pub(super) fn with_method(mut error: ConfigError, method: &str) -> ConfigError {
    error.help = error.help.map(|help| help.replace("`?", &format!("::{method}`?")));
    error
}

fn last(path: &str) -> &str {
    path.rsplit("::").next().unwrap_or(path)
}

pub(super) fn described(def: &Def) -> &'static str {
    match def {
        Def::Module(_) => "a module",
        Def::Type(_) | Def::Alias(_) => "a type",
        Def::Variant(..) => "a variant",
        Def::Trait(_) => "a trait",
        Def::Function(_) => "a function",
        Def::Value(_) => "a constant or static",
        Def::External(_) => "not read",
    }
}

/// Traits outside the analysed code that give a type no method that could be a law.
fn is_without_methods(path: &str) -> bool {
    path.starts_with("std::") && !matches!(path, "std::ops::Deref" | "std::ops::DerefMut" | "std::iter::Iterator")
}
