//! What a path means in a module: `use`, globs, re-exports, `crate`, `self`, `super`, extern crates, the prelude.

use std::collections::BTreeSet;

use rustc_hash::FxHashMap;

use super::known;
use super::{CrateId, Def, Entry, Index, ModuleId, Shape, TraitId};
use crate::source::FileId;

/// Types and values have names of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Namespace {
    /// Modules, types, traits.
    Type,
    /// Functions, constants, statics, tuple structs.
    Value,
}

/// What was looked up on the way to an answer: a name that is asked for again while it is looked up is not found, so that
/// imports that lead to each other end, and each name of each module is looked up once.
#[derive(Default)]
pub(super) struct Trail {
    answers: FxHashMap<(ModuleId, Namespace, String), Option<Def>>,
}

/// What a glob brings into scope.
#[derive(Debug, Default)]
pub struct Globbed {
    /// The names.
    pub names: BTreeSet<String>,
    /// The traits among them.
    pub traits: BTreeSet<TraitId>,
    /// Whether traits that are not known may be among them.
    pub has_unknown: bool,
}

impl Index {
    /// What a glob of the path brings into scope, wherever in the crates it stands; what is private is taken for public.
    #[must_use]
    pub fn globbed(&self, crates: &BTreeSet<CrateId>, path: &[String]) -> Globbed {
        let mut found = Globbed::default();
        let mut seen = BTreeSet::new();
        for (at, module) in (0..).map(ModuleId).zip(&self.modules) {
            if crates.contains(&module.krate) && module.globs.iter().any(|glob| glob == path) {
                self.add_globbed(at, path, &mut found, &mut seen);
            }
        }
        found.has_unknown |= seen.is_empty();
        found
    }

    /// The traits with the other names that re-exports and imports give them.
    #[must_use]
    pub fn renamed_traits(&self) -> BTreeSet<(&str, TraitId)> {
        let modules = (0..).map(ModuleId).zip(&self.modules);
        let entries = modules.flat_map(|(at, module)| module.names.iter().map(move |named| (at, named)));
        let renamed = entries.filter_map(|(at, ((namespace, name), entry))| match entry {
            Entry::Import(path) if *namespace == Namespace::Type && path.last() != Some(name) => {
                let Some(Def::Trait(id)) = self.resolve(at, path, Namespace::Type) else { return None };
                Some((name.as_str(), id))
            }
            _ => None,
        });
        renamed.collect()
    }

    /// The modules whose items stand in files, with those files.
    pub fn modules_in_files(&self) -> impl Iterator<Item = (ModuleId, FileId)> {
        (0..).map(ModuleId).zip(&self.modules).filter_map(|(id, module)| Some((id, module.file?)))
    }

    /// The modules in a file that import something by a name.
    #[must_use]
    pub fn importing(&self, file: FileId, name: &str) -> BTreeSet<ModuleId> {
        let key = (Namespace::Type, name.to_owned());
        let is_import = |id: &ModuleId| matches!(self.module(*id).names.get(&key), Some(Entry::Import(_)));
        self.modules_in_files().filter(|(_, own)| *own == file).map(|(id, _)| id).filter(is_import).collect()
    }

    /// The path of the `use` by which a module has an item: that of the item, or that of a module with all that is in it, if it has
    /// only one such module.
    #[must_use]
    pub fn import_of(&self, module: ModuleId, item: &str) -> Option<&[String]> {
        let own = self.module(module);
        match own.names.get(&(Namespace::Type, item.to_owned())) {
            Some(Entry::Import(path)) => Some(path),
            Some(Entry::Def(_)) => None,
            None => match own.globs.as_slice() {
                [glob] => Some(glob),
                _ => None,
            },
        }
    }

    /// Whether a module imports one of the names from one of these modules, or all that is there.
    #[must_use]
    pub fn imports_from(&self, module: ModuleId, from: &BTreeSet<ModuleId>, names: &BTreeSet<&str>) -> bool {
        let is_from = |path: &[String]| {
            let target = self.resolve_import(module, path, Namespace::Type, &mut Trail::default());
            matches!(target, Some(Def::Module(at)) if from.contains(&at))
        };
        let is_one = |entry: &Entry| match entry {
            Entry::Import(path) => {
                path.split_last().is_some_and(|(last, module)| names.contains(last.as_str()) && is_from(module))
            }
            Entry::Def(_) => false,
        };
        let own = self.module(module);
        // What a module has by its name, it has from no glob.
        let has_own = |name: &&str| match own.names.get(&(Namespace::Type, (*name).to_owned())) {
            Some(entry) => !is_one(entry),
            None => false,
        };
        let by_glob = names.is_empty() || !names.iter().all(has_own);
        by_glob && own.globs.iter().any(|glob| is_from(glob)) || own.names.values().any(is_one)
    }

    fn add_globbed(&self, from: ModuleId, path: &[String], found: &mut Globbed, seen: &mut BTreeSet<ModuleId>) {
        let target = self.resolve_import(from, path, Namespace::Type, &mut Trail::default());
        let Some(Def::Module(target)) = target else {
            found.has_unknown = true;
            return;
        };
        if !seen.insert(target) {
            return;
        }
        let module = self.module(target);
        let names: BTreeSet<&String> = module.names.keys().map(|(_, name)| name).collect();
        for name in names {
            let of = |namespace| self.resolve(target, std::slice::from_ref(name), namespace);
            match of(Namespace::Type) {
                Some(Def::Trait(id)) => drop(found.traits.insert(id)),
                Some(Def::External(_)) => found.has_unknown = true,
                None => found.has_unknown |= of(Namespace::Value).is_none(),
                Some(_) => {}
            }
            // Of all that is imported as `_`, only the first is known.
            found.has_unknown |= name == "_";
            found.names.insert(name.clone());
        }
        // What is there under a `cfg` only, and what macros make, may be a trait.
        found.names.extend(self.crate_of(target).removed.iter().cloned());
        found.has_unknown |= self.opaque_items.iter().any(|(at, _)| *at == target);
        for glob in &module.globs {
            self.add_globbed(target, glob, found, seen);
        }
    }

    /// What the path means in the module; `None` if nothing is found.
    #[must_use]
    pub fn resolve(&self, module: ModuleId, path: &[String], namespace: Namespace) -> Option<Def> {
        let key = (module, namespace, path.to_vec());
        if let Some(known) = self.resolved.read().ok().and_then(|known| known.get(&key).cloned()) {
            return known;
        }
        let found = self.resolve_path(module, path, namespace, &mut Trail::default());
        if let Ok(mut known) = self.resolved.write() {
            known.insert(key, found.clone());
        }
        found
    }

    fn resolve_path(&self, module: ModuleId, path: &[String], namespace: Namespace, trail: &mut Trail) -> Option<Def> {
        let (first, rest) = path.split_first()?;
        let first_namespace = if rest.is_empty() { namespace } else { Namespace::Type };
        let mut def = match first.as_str() {
            "crate" | "$crate" => Def::Module(self.crate_of(module).root),
            "self" => Def::Module(self.enclosing(module)),
            "super" => Def::Module(self.module(self.enclosing(module)).parent.map(|up| self.enclosing(up))?),
            "" => {
                let (name, more) = rest.split_first()?;
                if let Some(start) = self.extern_crate(self.module(module).krate, name) {
                    return self.resolve_rest(start, more, namespace, trail);
                }
                // In the 2015 edition it is the crate root that such a path begins at.
                return self.resolve_rest(Def::Module(self.crate_of(module).root), rest, namespace, trail);
            }
            name => self.resolve_first(module, name, first_namespace, rest.is_empty(), trail)?,
        };
        if matches!(first.as_str(), "crate" | "self" | "super" | "$crate") && rest.is_empty() {
            return Some(def);
        }
        if first == "super" {
            let mut rest = rest;
            while let (Some((next, more)), Def::Module(at)) = (rest.split_first(), &def)
                && next == "super"
            {
                def = Def::Module(self.module(*at).parent.map(|up| self.enclosing(up))?);
                rest = more;
            }
            return self.resolve_rest(def, rest, namespace, trail);
        }
        self.resolve_rest(def, rest, namespace, trail)
    }

    fn resolve_first(
        &self,
        module: ModuleId,
        name: &str,
        namespace: Namespace,
        is_last: bool,
        trail: &mut Trail,
    ) -> Option<Def> {
        let mut scope = Some(module);
        while let Some(at) = scope {
            if let Some(def) = self.name_in(at, name, namespace, trail) {
                return Some(def);
            }
            let module = self.module(at);
            scope = if module.is_block { module.parent } else { None };
        }
        if (!is_last || namespace == Namespace::Type)
            && let Some(def) = self.extern_crate(self.module(module).krate, name)
        {
            return Some(def);
        }
        // `Eq { … }` is no trait of the prelude where a type has that name: its traits and types are no values.
        let is_there = namespace == Namespace::Type || known::is_prelude_value(name);
        known::prelude(name).filter(|_| is_there).map(|path| Def::External(path.to_owned()))
    }

    fn resolve_rest(&self, start: Def, rest: &[String], namespace: Namespace, trail: &mut Trail) -> Option<Def> {
        let mut def = start;
        for (number, name) in rest.iter().enumerate() {
            let namespace = if number + 1 == rest.len() { namespace } else { Namespace::Type };
            def = self.member(&def, name, namespace, trail)?;
        }
        Some(def)
    }

    fn member(&self, def: &Def, name: &str, namespace: Namespace, trail: &mut Trail) -> Option<Def> {
        match def {
            Def::Module(module) => self.name_in(*module, name, namespace, trail),
            Def::Type(id) => match &self.type_def(*id).shape {
                Shape::Enum(variants) => {
                    variants.iter().position(|variant| variant.name == name).map(|number| Def::Variant(*id, number))
                }
                Shape::Struct(_) => None,
            },
            Def::Alias(id) => {
                let alias = &self.aliases[id.0 as usize];
                let crate::syntax::tree::TypeRef::Path(path) = &alias.ty else { return None };
                let target = self.resolve_path(alias.module, &segments(path), Namespace::Type, trail)?;
                self.member(&target, name, namespace, trail)
            }
            Def::External(path) => {
                // What a prelude hands out is what the crate declares elsewhere.
                let known = if path.ends_with("::prelude") { self.glob_member(path, name) } else { None };
                let path = known.unwrap_or_else(|| known::canonical(&format!("{path}::{name}")));
                Some(Def::External(path))
            }
            Def::Variant(..) | Def::Trait(_) | Def::Function(_) | Def::Value(_) => None,
        }
    }

    /// A name in a module: its own items and imports first, then globs.
    fn name_in(&self, module: ModuleId, name: &str, namespace: Namespace, trail: &mut Trail) -> Option<Def> {
        let key = (module, namespace, name.to_owned());
        if let Some(answer) = trail.answers.get(&key) {
            return answer.clone();
        }
        trail.answers.insert(key.clone(), None);
        let found = self.search_name(module, name, namespace, trail);
        trail.answers.insert(key, found.clone());
        found
    }

    fn search_name(&self, module: ModuleId, name: &str, namespace: Namespace, trail: &mut Trail) -> Option<Def> {
        let data = self.module(module);
        match data.names.get(&(namespace, name.to_owned())) {
            Some(Entry::Def(def)) => return Some(def.clone()),
            Some(Entry::Import(path)) => {
                let found = self.resolve_import(module, path, namespace, trail);
                if found.is_some() {
                    return found;
                }
            }
            None => {}
        }
        for glob in &data.globs {
            let found = match self.resolve_import(module, glob, Namespace::Type, trail) {
                Some(Def::Module(target)) if target != module => self.name_in(target, name, namespace, trail),
                Some(Def::External(path)) => self.glob_member(&path, name).map(Def::External),
                Some(target @ (Def::Type(_) | Def::Alias(_))) => self.member(&target, name, namespace, trail),
                _ => None,
            };
            if found.is_some() {
                return found;
            }
        }
        None
    }

    /// The path of a `use`. A name that it binds itself must not be found through the import of the same name.
    pub(super) fn resolve_import(
        &self,
        module: ModuleId,
        path: &[String],
        namespace: Namespace,
        trail: &mut Trail,
    ) -> Option<Def> {
        let first = path.first()?;
        let own = self.module(module).names.get(&(Namespace::Type, first.clone()));
        if let Some(Entry::Import(target)) = own
            && target == path
        {
            // `use tokio;` or `use a::b as a;`: the first name is a crate.
            let start = self.extern_crate(self.module(module).krate, first)?;
            return self.resolve_rest(start, &path[1..], namespace, trail);
        }
        if let Some(Entry::Import(target)) = own
            && target.first() == Some(first)
        {
            // `use pid::Pid; use pid as pid;` and the like: the crate is meant.
            if let Some(start) = self.extern_crate(self.module(module).krate, first) {
                return self.resolve_rest(start, &path[1..], namespace, trail);
            }
        }
        self.resolve_path(module, path, namespace, trail)
    }

    fn extern_crate(&self, krate: CrateId, name: &str) -> Option<Def> {
        let info = &self.crates[krate.0 as usize];
        match info.externs.get(name) {
            Some((Some(id), _)) => return Some(Def::Module(self.crates[id.0 as usize].root)),
            Some((None, package)) => return Some(Def::External(known::canonical(&package.replace('-', "_")))),
            None => {}
        }
        let is_known = matches!(name, "std" | "core" | "alloc" | "ceid_core");
        is_known.then(|| Def::External(known::canonical(name)))
    }

    /// The module itself, or the one around a block.
    fn enclosing(&self, module: ModuleId) -> ModuleId {
        let mut at = module;
        while self.module(at).is_block
            && let Some(parent) = self.module(at).parent
        {
            at = parent;
        }
        at
    }
}

/// The names of a path.
pub(super) fn segments(path: &crate::syntax::tree::Path) -> Vec<String> {
    let mut names = Vec::new();
    if path.global {
        names.push(String::new());
    }
    names.extend(path.segments.iter().map(|segment| segment.name.clone()));
    names
}
