//! What the entries of the configuration name: items of the analysed code, or paths into crates whose sources are not read.
//! A path that names nothing is an error with its place and the nearest right spelling.

use std::collections::BTreeSet;

use super::entry_errors::{described, is_of_std, with_method};
use super::filters::{FilterSpec, Subject};
use super::{CrateId, CrateInfo, Def, FunctionId, Index, ModuleId, Namespace, Owner, TraitName, Ty, TypeId};
use crate::config::spelling::nearest;
use crate::config::{ConfigError, CycleEntry, CycleTarget, FilterEntry, FilterTarget, GuardEntry, Word};

/// Where the entries of a section look for what they name.
#[derive(Debug)]
pub struct EntryScope<'a> {
    /// The crates that `crate` means.
    pub crates: Vec<CrateId>,
    /// The packages of the dependency graph.
    pub graph: &'a BTreeSet<String>,
    /// Whether some of their code was not read, so that what is not found may lie there.
    pub is_partial: bool,
    /// The number of the section, of those of one configuration.
    pub section: usize,
}

/// A filter that an entry has named.
#[derive(Debug)]
pub(super) struct Entered {
    subject: Subject,
    section: usize,
    line: u32,
}

/// A function that is a cycle because the configuration says so.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CycleSpec {
    /// This one.
    Function(FunctionId),
    /// A method of a trait, in every implementation.
    Method(TraitName, String),
    /// Every function with the attribute.
    Attribute(String),
}

/// A guard type that the configuration names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GuardSpec {
    ty: GuardType,
    /// The function or method whose arguments are the guarded filters.
    pub register: String,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum GuardType {
    Local(TypeId),
    External(String),
}

/// One of two entries would hold, and nobody could see which.
fn has_two_entries(word: &Word, line: u32) -> ConfigError {
    let message = format!("the filter `{}` has an entry in line {line} as well, which says something else", word.text);
    ConfigError::at(word.place.clone(), message)
        .help("write one entry: in `law`, methods are alternatives in one list, and halves in two: `[[\"predict\"], [\"correct\"]]`")
}

/// A type would be judged by one of two laws, and nobody could see by which.
fn has_two_laws(word: &Word, ty: &str, line: u32, own: &FilterSpec, other: &FilterSpec) -> ConfigError {
    let message = format!(
        "`{ty}` implements `{}` and the trait of the entry in line {line} as well, which says something else",
        word.text
    );
    let mut groups: Vec<&[String]> = own.law.iter().map(|group| group.methods.as_slice()).collect();
    let further = other.law.iter().map(|group| group.methods.as_slice());
    groups.extend(further.filter(|group| !own.law.iter().any(|own| own.methods == *group)));
    let each = if groups.len() > 1 { ", if each of these is a part of it" } else { "" };
    ConfigError::at(word.place.clone(), message)
        .help(format!("write an entry with `type` for `{ty}`, which stands over its traits: `law = {groups:?}`{each}"))
}

impl Index {
    /// Makes a filter of what an entry of the configuration names.
    ///
    /// # Errors
    /// If it names nothing, or if its law or its resets do.
    pub fn add_filter(&mut self, scope: &EntryScope<'_>, entry: &FilterEntry) -> Result<(), ConfigError> {
        let word = entry.target.path();
        let found = match &entry.target {
            FilterTarget::Function(_) => self.laws_named(scope, word),
            FilterTarget::Type(_) => self.named(scope, word, Namespace::Type, "type"),
            FilterTarget::Trait(_) => self.named(scope, word, Namespace::Type, "trait"),
        };
        let mut found = found.map_err(|error| {
            let values = self.named_by(scope, &word.text, Namespace::Value);
            let function = values.iter().find(|def| matches!(def, Def::Function(_)));
            function.map_or(error, |def| self.is_something_else(word, def, &entry.target))
        })?;
        for def in &found {
            if matches!(def, Def::External(path) if path.starts_with("std::")) {
                return Err(is_of_std(word));
            }
            if self.subject(def, &entry.target).is_none() {
                return Err(self.is_something_else(word, def, &entry.target));
            }
        }
        // Another type of that path may have no such law: an entry holds where the law is.
        let checked: Vec<_> = found.iter().map(|def| self.check_methods(scope, def, entry)).collect();
        if checked.iter().any(Result::is_ok) {
            let mut checked = checked.into_iter();
            found.retain(|_| checked.next().is_some_and(|checked| checked.is_ok()));
        } else if let Some(Err(error)) = checked.into_iter().next() {
            return Err(error);
        }
        self.check_arguments(scope, &found, entry)?;
        self.check_makers(scope, entry)?;
        for def in found {
            let Some(subject) = self.subject(&def, &entry.target) else { continue };
            self.note_makers(&subject, entry);
            self.note_reset_functions(scope, &def, entry);
            let spec = FilterSpec::by_entry(subject, entry);
            match self.entered.iter().find(|known| known.subject == spec.subject) {
                Some(known) if known.section == scope.section => {
                    let at = self.specs.iter().position(|own| own.subject == spec.subject);
                    if at.is_some_and(|at| self.specs[at] != spec) {
                        return Err(has_two_entries(word, known.line));
                    }
                }
                // What a package says stands over what its workspace says.
                Some(_) => {
                    self.specs.retain(|own| own.subject != spec.subject);
                    self.enter(scope, word, spec);
                }
                None if self.specs.iter().any(|own| own.subject == spec.subject) => {}
                None => self.enter(scope, word, spec),
            }
        }
        Ok(())
    }

    fn check_methods(&self, scope: &EntryScope<'_>, def: &Def, entry: &FilterEntry) -> Result<(), ConfigError> {
        if matches!(entry.target, FilterTarget::Function(_)) {
            return self.check_resets(scope, def, entry);
        }
        let word = entry.target.path();
        for method in entry.law.iter().flatten() {
            self.check_method(scope, def, word, method)?;
        }
        self.check_resets(scope, def, entry)
    }

    /// Checks that no type has another law by another trait of the same section, for one of the two would not be judged.
    ///
    /// # Errors
    /// If a type has.
    pub fn check_one_law(&self, scope: &EntryScope<'_>, entry: &FilterEntry) -> Result<(), ConfigError> {
        let FilterTarget::Trait(word) = &entry.target else { return Ok(()) };
        for def in self.named_by(scope, &word.text, Namespace::Type) {
            let Some(Subject::Trait(name)) = self.subject(&def, &entry.target) else { continue };
            let own = FilterSpec::by_entry(Subject::Trait(name.clone()), entry);
            for number in (0u32..).zip(&self.types).map(|(number, _)| TypeId(number)) {
                let ty = self.bare(number);
                let Some(other) = self.law_spec(&ty).filter(|_| self.implements(&ty, &name)) else { continue };
                let known = self.entered.iter().find(|known| known.subject == other.subject);
                let is_by_trait = other.subject != own.subject && matches!(other.subject, Subject::Trait(_));
                if let Some(known) = known.filter(|known| is_by_trait && known.section == scope.section)
                    && (FilterSpec { subject: own.subject.clone(), ..other.clone() }) != own
                {
                    return Err(has_two_laws(word, &self.type_name(&ty), known.line, &own, other));
                }
            }
        }
        Ok(())
    }

    fn enter(&mut self, scope: &EntryScope<'_>, word: &Word, spec: FilterSpec) {
        self.entered.retain(|known| known.subject != spec.subject);
        self.entered.push(Entered { subject: spec.subject.clone(), section: scope.section, line: word.place.line });
        self.specs.insert(0, spec);
    }

    fn note_makers(&mut self, subject: &Subject, entry: &FilterEntry) {
        if let Subject::External(path) = subject {
            for maker in &entry.made_by {
                self.makers.entry(maker.text.clone()).or_insert_with(|| path.clone());
            }
        }
    }

    /// The filter type that a function of a crate whose sources are not read gives, if an entry says so.
    #[must_use]
    pub fn made_by(&self, path: &str) -> Option<Ty> {
        self.makers.get(path).map(|path| Ty::External(path.clone(), Vec::new()))
    }

    /// The filter type that methods of a builder give; none if the type at the path is no builder.
    #[must_use]
    pub fn built_by(&self, path: &str) -> Option<Ty> {
        let start = format!("{path}::");
        let (maker, made) = self.makers.range(start.clone()..).next()?;
        maker.starts_with(&start).then(|| Ty::External(made.clone(), Vec::new()))
    }

    /// Makes a filter of what an entry of a preset names, where the configuration says nothing of it.
    pub fn add_preset_filter(&mut self, scope: &EntryScope<'_>, entry: &FilterEntry) {
        let word = entry.target.path();
        let namespace = match entry.target {
            FilterTarget::Function(_) => Namespace::Value,
            FilterTarget::Type(_) | FilterTarget::Trait(_) => Namespace::Type,
        };
        // A crate of that name whose sources are read may be the preset's own, or another one that shares the name.
        let mut found = self.named_by(scope, &word.text, namespace);
        let has_law = |def: &Def| {
            matches!(def, Def::Function(_) | Def::External(_))
                || entry.law.iter().flatten().all(|method| self.has_method(def, &method.text) != Some(false))
        };
        found.retain(has_law);
        found.push(Def::External(word.text.clone()));
        for def in found {
            if let Some(subject) = self.subject(&def, &entry.target)
                && !self.specs.iter().any(|spec| spec.subject == subject)
            {
                self.note_makers(&subject, entry);
                self.note_reset_functions(scope, &def, entry);
                self.specs.push(FilterSpec { is_preset: true, ..FilterSpec::by_entry(subject, entry) });
            }
        }
    }

    /// Makes a cycle of what an entry names.
    ///
    /// # Errors
    /// If it names nothing.
    pub fn add_cycle(&mut self, scope: &EntryScope<'_>, entry: &CycleEntry) -> Result<(), ConfigError> {
        let word = entry.target.path();
        match &entry.target {
            CycleTarget::Function(_) => {
                let functions = self.functions_named(scope, word)?;
                self.cycles.extend(functions.into_iter().map(CycleSpec::Function));
            }
            CycleTarget::Method(_) => {
                let Some((of, name)) = word.text.rsplit_once("::") else { return Ok(()) };
                let of = Word { text: of.to_owned(), place: word.place.clone() };
                let method = Word { text: name.to_owned(), place: word.place.clone() };
                let traits = self.named(scope, &of, Namespace::Type, "trait");
                for def in traits.map_err(|error| with_method(error, name))? {
                    let of_trait = match def {
                        Def::Trait(id) => TraitName::Local(id),
                        Def::External(ref path) => TraitName::External(path.clone()),
                        _ => {
                            let message = format!("`{}` is {}, not a trait", of.text, described(&def));
                            return Err(ConfigError::at(word.place.clone(), message)
                                .help(format!("write `function = \"{}\"`", word.text)));
                        }
                    };
                    self.check_method(scope, &def, &of, &method)?;
                    self.cycles.push(CycleSpec::Method(of_trait, name.to_owned()));
                }
            }
            CycleTarget::Attribute(_) => self.add_cycle_attribute(scope, word)?,
        }
        Ok(())
    }

    /// Makes a guard of the type that an entry names.
    ///
    /// # Errors
    /// If it names nothing.
    pub fn add_guard(&mut self, scope: &EntryScope<'_>, entry: &GuardEntry) -> Result<(), ConfigError> {
        for def in self.named(scope, &entry.guard_type, Namespace::Type, "type")? {
            let ty = match &def {
                Def::Type(id) => GuardType::Local(*id),
                Def::External(path) => GuardType::External(path.clone()),
                _ => {
                    let message = format!("`{}` is {}, not a type", entry.guard_type.text, described(&def));
                    return Err(ConfigError::at(entry.guard_type.place.clone(), message));
                }
            };
            self.check_register(scope, &def, entry)?;
            self.guards.push(GuardSpec { ty, register: entry.register.text.clone() });
        }
        Ok(())
    }

    /// What the configuration says of a type as a guard.
    #[must_use]
    pub fn guard_spec(&self, ty: &Ty) -> Option<&GuardSpec> {
        self.guards.iter().find(|spec| match (&spec.ty, ty) {
            (GuardType::Local(own), Ty::Adt(id, _)) => own == id,
            (GuardType::External(own), Ty::External(path, _)) => own == path,
            _ => false,
        })
    }

    /// Whether the configuration says that the function is a cycle.
    #[must_use]
    pub fn is_declared_cycle(&self, id: FunctionId) -> bool {
        let def = self.function(id);
        self.cycles.iter().any(|spec| match spec {
            CycleSpec::Function(own) => *own == self.origin(id),
            CycleSpec::Method(of, name) => {
                let of_function = match def.owner {
                    Owner::Impl(owner) => self.impl_def(owner).implements.clone(),
                    Owner::Trait(owner) => Some(TraitName::Local(owner)),
                    Owner::Module => None,
                };
                def.name == *name && of_function.as_ref() == Some(of)
            }
            CycleSpec::Attribute(path) => {
                def.attributes.iter().any(|attribute| self.is_attribute(def.module, &attribute.path, path))
            }
        })
    }

    /// Whether an attribute as it is written is the one with that path: `#[task]` may stand for `rtic::task` when nothing else
    /// of that name is in scope, because some attributes are only there for the macro around them.
    fn is_attribute(&self, module: ModuleId, written: &str, path: &str) -> bool {
        let names: Vec<String> = written.split("::").map(str::to_owned).collect();
        match self.resolve(module, &names, Namespace::Value).or_else(|| self.resolve(module, &names, Namespace::Type)) {
            Some(Def::External(found)) if found != written => found == path,
            _ => path == written || path.ends_with(&format!("::{written}")),
        }
    }

    fn add_cycle_attribute(&mut self, scope: &EntryScope<'_>, word: &Word) -> Result<(), ConfigError> {
        let functions = || self.functions.iter().filter(|def| scope.crates.contains(&self.module(def.module).krate));
        let is_used = functions().any(|def| {
            def.attributes.iter().any(|attribute| self.is_attribute(def.module, &attribute.path, &word.text))
        });
        let first = word.text.split("::").next().unwrap_or_default();
        let is_of_dependency = first != word.text && self.is_crate_name(scope, first);
        if is_used || is_of_dependency || scope.is_partial {
            self.cycles.push(CycleSpec::Attribute(word.text.clone()));
            return Ok(());
        }
        let seen: BTreeSet<&str> =
            functions().flat_map(|def| &def.attributes).map(|attribute| attribute.path.as_str()).collect();
        let error = ConfigError::at(word.place.clone(), format!("no function has the attribute `{}`", word.text));
        Err(match nearest(&word.text, seen) {
            Some(name) => error.help(format!("did you mean `{name}`?")),
            None => error,
        })
    }

    /// A function, or a method as `crate::Robot::step`.
    pub(super) fn functions_named(&self, scope: &EntryScope<'_>, word: &Word) -> Result<Vec<FunctionId>, ConfigError> {
        let found = self.named_by(scope, &word.text, Namespace::Value);
        let mut functions: Vec<FunctionId> = found
            .iter()
            .filter_map(|def| match def {
                Def::Function(id) => Some(*id),
                _ => None,
            })
            .collect();
        if let Some((of, name)) = word.text.rsplit_once("::") {
            for def in self.named_by(scope, of, Namespace::Type) {
                if let Def::Type(id) = def {
                    let owners = self.methods(&self.bare(id), name);
                    functions.extend(owners.iter().filter_map(super::MethodOwner::function));
                }
            }
        }
        if functions.is_empty() && !found.iter().any(|def| matches!(def, Def::External(_))) {
            let methods =
                word.text.rsplit_once("::").map(|(of, name)| (self.named_by(scope, of, Namespace::Type), of, name));
            if let Some((defs, of, name)) = methods
                && let Some(def) = defs.first().filter(|def| matches!(def, Def::Type(_) | Def::Trait(_)))
            {
                if matches!(def, Def::Trait(_)) {
                    let message = format!("`{of}` is a trait, so that `{name}` is a method of many types");
                    return Err(ConfigError::at(word.place.clone(), message)
                        .help(format!("write `method = \"{}\"`", word.text)));
                }
                let of = Word { text: of.to_owned(), place: word.place.clone() };
                let method = Word { text: name.to_owned(), place: word.place.clone() };
                self.check_method(scope, def, &of, &method)?;
                return Ok(functions);
            }
            self.named(scope, word, Namespace::Value, "function")?;
            if let Some(other) = found.first() {
                return Err(self.is_no_function(word, other));
            }
        }
        Ok(functions)
    }

    /// A function that is a law, or an associated one as `crate::Fir::run`: one with a receiver is a law of its type.
    fn laws_named(&self, scope: &EntryScope<'_>, word: &Word) -> Result<Vec<Def>, ConfigError> {
        if !self.named_by(scope, &word.text, Namespace::Value).is_empty() {
            return self.named(scope, word, Namespace::Value, "function");
        }
        let functions = self.functions_named(scope, word)?;
        if let Some((of, name)) = word.text.rsplit_once("::")
            && functions.iter().any(|id| self.function(*id).function.receiver.is_some())
        {
            let message = format!("`{}` is a method, so that its state is the value that it is called on", word.text);
            return Err(ConfigError::at(word.place.clone(), message)
                .help(format!("write `type = \"{of}\"` and `law = \"{name}\"`")));
        }
        Ok(functions.into_iter().map(Def::Function).collect())
    }

    pub(super) fn bare(&self, id: TypeId) -> Ty {
        Ty::Adt(id, vec![Ty::Unknown; self.type_def(id).generics.params.len()])
    }

    fn subject(&self, def: &Def, target: &FilterTarget) -> Option<Subject> {
        Some(match (def, target) {
            (Def::Function(_) | Def::External(_), FilterTarget::Function(_)) => Subject::Function(def.clone()),
            (Def::Type(id), FilterTarget::Type(_)) => Subject::Type(*id),
            (Def::Trait(id), FilterTarget::Trait(_)) => Subject::Trait(TraitName::Local(*id)),
            (Def::External(path), FilterTarget::Type(_)) => Subject::External(path.clone()),
            (Def::External(path), FilterTarget::Trait(_)) => Subject::Trait(TraitName::External(path.clone())),
            _ => return None,
        })
    }

    /// What a path names, in every crate of the scope; an error if that is nothing.
    fn named(
        &self,
        scope: &EntryScope<'_>,
        word: &Word,
        namespace: Namespace,
        wanted: &str,
    ) -> Result<Vec<Def>, ConfigError> {
        let found = self.named_by(scope, &word.text, namespace);
        if !found.is_empty() || scope.is_partial || self.is_removed(scope, &word.text) {
            return Ok(found);
        }
        Err(self.names_nothing(scope, word, wanted))
    }

    /// Everything that an entry with this path would name.
    #[must_use]
    pub fn named_by(&self, scope: &EntryScope<'_>, path: &str, namespace: Namespace) -> Vec<Def> {
        let names: Vec<String> = path.split("::").map(str::to_owned).collect();
        let Some((first, rest)) = names.split_first() else { return Vec::new() };
        let in_member = |info: &CrateInfo| {
            let is_member = first == "crate" || info.name == *first || info.package_name == *first;
            let own: Vec<String> = std::iter::once("crate".to_owned()).chain(rest.iter().cloned()).collect();
            if is_member { self.resolve(info.root, &own, namespace) } else { None }
        };
        let in_each = |look: &dyn Fn(&CrateInfo) -> Option<Def>| {
            let mut found: Vec<Def> = Vec::new();
            for krate in &scope.crates {
                let def = look(self.crate_info(*krate)).and_then(|def| self.behind_alias(def));
                found.extend(def.filter(|def| !found.contains(def)));
            }
            found
        };
        let mut found = in_each(&in_member);
        if first == "crate" || !found.is_empty() {
            return found;
        }
        found = in_each(&|info| self.resolve(info.root, &names, namespace));
        // The package's own name also names a dependency that is renamed, or that comes by way of another one.
        let is_read = self.crates.iter().any(|info| info.name == *first || info.package_name == *first);
        if found.is_empty() && names.len() > 1 && !is_read && is_in_graph(scope, first) {
            found.push(Def::External(path.to_owned()));
        }
        found
    }

    pub(super) fn crate_info(&self, id: CrateId) -> &CrateInfo {
        &self.crates[id.0 as usize]
    }

    /// The type that an alias stands for.
    pub(super) fn behind_alias(&self, def: Def) -> Option<Def> {
        let Def::Alias(id) = def else { return Some(def) };
        let alias = &self.aliases[id.0 as usize];
        let scope = self.scope(alias.module, Owner::Module, Some(&alias.generics));
        match self.lower(&alias.ty, &scope) {
            Ty::Adt(id, _) => Some(Def::Type(id)),
            Ty::External(path, _) => Some(Def::External(path)),
            _ => None,
        }
    }

    pub(super) fn is_crate_name(&self, scope: &EntryScope<'_>, name: &str) -> bool {
        matches!(name, "crate" | "std" | "core" | "alloc")
            || is_in_graph(scope, name)
            || scope.crates.iter().any(|krate| {
                let info = self.crate_info(*krate);
                info.externs.contains_key(name) || info.name == name || info.package_name == name
            })
    }
}

fn is_in_graph(scope: &EntryScope<'_>, name: &str) -> bool {
    scope.graph.iter().any(|package| package.replace('-', "_") == name)
}
