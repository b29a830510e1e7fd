//! What an entry says that resets its filter: methods by their names, and functions by their paths that are lent it.

use super::entries::EntryScope;
use super::states::is_like;
use super::{Def, FunctionId, Index, MethodOwner, Namespace, TraitName, Ty, TypeId};
use crate::config::{ConfigError, FilterEntry, FilterTarget, InstancePlace, Word};
use crate::syntax::tree::Receiver;

/// A function that resets a filter which it is lent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ResetFunction {
    def: Def,
    /// The number of the parameter, `self` first; `None` if its code is not read.
    pub parameter: Option<usize>,
    /// Whether all of the filter is reset.
    pub is_full: bool,
}

impl Index {
    /// What is known of a function as one that resets what it is lent.
    #[must_use]
    pub fn reset_by(&self, def: &Def) -> Option<&ResetFunction> {
        self.reset_functions.iter().find(|own| own.def == *def)
    }

    /// Checks what an entry says of resets.
    ///
    /// # Errors
    /// If something of it names nothing, or nothing that could reset the filter.
    pub(super) fn check_resets(
        &self,
        scope: &EntryScope<'_>,
        def: &Def,
        entry: &FilterEntry,
    ) -> Result<(), ConfigError> {
        let states = self.states_of(def, entry);
        for word in entry.reset.iter().chain(&entry.partial_reset) {
            if word.text.contains("::") {
                self.reset_functions_named(scope, def, entry, word)?;
            } else if matches!(entry.target, FilterTarget::Function(_)) {
                self.check_reset_of_state(scope, &states, word)?;
            } else if !states.iter().any(|ty| self.is_method_of(scope, ty, word)) {
                self.check_reset(scope, def, entry.target.path(), word)?;
            }
        }
        Ok(())
    }

    /// Notes the functions that an entry names as resets.
    pub(super) fn note_reset_functions(&mut self, scope: &EntryScope<'_>, def: &Def, entry: &FilterEntry) {
        let words = entry.reset.iter().map(|word| (word, true));
        for (word, is_full) in words.chain(entry.partial_reset.iter().map(|word| (word, false))) {
            if word.text.contains("::") {
                let found = self.reset_functions_named(scope, def, entry, word).unwrap_or_default();
                self.reset_functions.extend(found.into_iter().map(|(def, parameter)| ResetFunction {
                    def,
                    parameter,
                    is_full,
                }));
            }
        }
    }

    /// The functions that a path names as resets of a filter, each with the parameter that it has it in.
    fn reset_functions_named(
        &self,
        scope: &EntryScope<'_>,
        def: &Def,
        entry: &FilterEntry,
        word: &Word,
    ) -> Result<Vec<(Def, Option<usize>)>, ConfigError> {
        let unread = self.named_by(scope, &word.text, Namespace::Value).into_iter();
        let mut found: Vec<(Def, Option<usize>)> =
            unread.filter(|def| matches!(def, Def::External(_))).map(|def| (def, None)).collect();
        let functions = if found.is_empty() { self.functions_named(scope, word)? } else { Vec::new() };
        for id in &functions {
            let parameter = self.parameter_with_state(*id, def, entry);
            found.extend(parameter.map(|parameter| (Def::Function(*id), Some(parameter))));
        }
        if found.is_empty() && !functions.is_empty() {
            let message =
                format!("`{}` is lent no `{}` that it could reset", word.text, self.name_of_state(def, entry));
            return Err(ConfigError::at(word.place.clone(), message)
                .help("name a function that takes the state as `&mut`, or a method by its name alone"));
        }
        Ok(found)
    }

    /// The parameter through which a function could reset a filter of an entry.
    fn parameter_with_state(&self, id: FunctionId, def: &Def, entry: &FilterEntry) -> Option<usize> {
        let states = self.states_of(def, entry);
        let scope = self.scope_of(id);
        let function = &self.function(id).function;
        let is_state = |ty: &Ty| match def {
            _ if states.iter().any(|state| is_like(state, ty)) => true,
            Def::Trait(of) if entry.instance == InstancePlace::Receiver => self.implements(ty, &TraitName::Local(*of)),
            Def::External(path) => match entry.target {
                FilterTarget::Type(_) => matches!(ty, Ty::External(own, _) if own == path),
                FilterTarget::Trait(_) => self.implements(ty, &TraitName::External(path.clone())),
                FilterTarget::Function(_) => true,
            },
            _ => matches!(ty, Ty::Unknown | Ty::Param(_) | Ty::Opaque(_)),
        };
        let of_self = match function.receiver {
            Some(Receiver::Exclusive) => vec![scope.self_ty.clone().filter(&is_state)],
            Some(_) => vec![None],
            None => Vec::new(),
        };
        let lent = function.params.iter().map(|ty| match self.lower(ty, &scope) {
            Ty::Ref(true, inner) => Some(*inner).filter(&is_state),
            Ty::Pointer(inner) => Some(*inner).filter(&is_state),
            _ => None,
        });
        of_self.into_iter().chain(lent).position(|ty| ty.is_some())
    }

    /// The types of what an entry's laws change, as far as they are seen.
    fn states_of(&self, def: &Def, entry: &FilterEntry) -> Vec<Ty> {
        if let (Def::Type(id), InstancePlace::Receiver) = (def, entry.instance) {
            return vec![self.bare(*id)];
        }
        let laws = entry.law.iter().flatten().flat_map(|method| self.functions_of_law(def, &method.text));
        let mut found = Vec::new();
        for law in laws {
            let (scope, function) = (self.scope_of(law), &self.function(law).function);
            match entry.instance {
                InstancePlace::Receiver => {}
                InstancePlace::Argument(number) => {
                    let ty = function.params.get(number as usize).map(|ty| self.lower(ty, &scope).peel().clone());
                    found.extend(ty);
                }
                InstancePlace::Returned => {
                    let output = self.lower(&function.output, &scope);
                    let params = function.params.iter().map(|ty| self.lower(ty, &scope).peel().clone());
                    found.extend(params.filter(|ty| super::handed(&output, ty).is_some()));
                }
            }
        }
        found
    }

    fn name_of_state(&self, def: &Def, entry: &FilterEntry) -> String {
        match self.states_of(def, entry).first() {
            Some(ty) => self.type_name(ty),
            None => entry.target.path().text.clone(),
        }
    }

    /// The functions that a method of a law may be, those that a trait only declares included.
    pub(super) fn functions_of_law(&self, def: &Def, method: &str) -> Vec<FunctionId> {
        match def {
            Def::Function(id) => vec![*id],
            Def::Type(id) => self.methods(&self.bare(*id), method).iter().filter_map(MethodOwner::function).collect(),
            Def::Trait(id) => {
                let declared = self.trait_def(*id).methods.get(method).copied();
                declared.into_iter().chain(self.implementations(&TraitName::Local(*id), method)).collect()
            }
            _ => Vec::new(),
        }
    }

    fn is_method_of(&self, scope: &EntryScope<'_>, ty: &Ty, method: &Word) -> bool {
        matches!(ty, Ty::Adt(id, _) if self.may_have_method(scope, &Def::Type(*id), method))
    }

    /// An error if a reset of a law that is a function is certainly no method of its state.
    fn check_reset_of_state(&self, scope: &EntryScope<'_>, states: &[Ty], word: &Word) -> Result<(), ConfigError> {
        if states.iter().any(|ty| self.is_method_of(scope, ty, word)) || scope.is_partial {
            return Ok(());
        }
        let functions = self.paths_of(scope, "crate", "function");
        let function = functions.iter().find(|path| path.rsplit("::").next() == Some(&word.text));
        let only: Option<TypeId> = match states {
            [Ty::Adt(id, _), rest @ ..] if rest.iter().all(|ty| matches!(ty, Ty::Adt(own, _) if own == id)) => {
                Some(*id)
            }
            _ => None,
        };
        match (only, function) {
            (_, Some(path)) => {
                let message = format!("`{}` is a function, and no method of the state", word.text);
                Err(ConfigError::at(word.place.clone(), message).help(format!("write its path: `{path}`")))
            }
            (Some(id), None) => {
                let name = &self.type_def(id).name;
                Err(self.has_no_method(&Def::Type(id), name, word))
            }
            (None, None) => Ok(()),
        }
    }

    /// An error if a type certainly has no such method to reset it; of a trait, if no type that implements it has, for that may be
    /// a method of the type itself or of another trait.
    fn check_reset(&self, scope: &EntryScope<'_>, def: &Def, owner: &Word, method: &Word) -> Result<(), ConfigError> {
        let is_of_type = |id: &TypeId| {
            let of = match def {
                Def::Trait(id) => TraitName::Local(*id),
                Def::External(path) => TraitName::External(path.clone()),
                _ => return false,
            };
            self.implements(&self.bare(*id), &of) && self.may_have_method(scope, &Def::Type(*id), method)
        };
        let mut types = (0u32..).zip(&self.types).map(|(number, _)| TypeId(number));
        if self.may_have_method(scope, def, method) || types.any(|id| is_of_type(&id)) {
            return Ok(());
        }
        Err(self.has_no_method(def, &owner.text, method))
    }

    /// Checks what gives filters of an unread crate.
    ///
    /// # Errors
    /// If something of it names nothing.
    pub(super) fn check_makers(&self, scope: &EntryScope<'_>, entry: &FilterEntry) -> Result<(), ConfigError> {
        for word in &entry.made_by {
            let found = self.named_by(scope, &word.text, Namespace::Value);
            let types = self.named_by(scope, &word.text, Namespace::Type);
            let is_method = || {
                let owner = word.text.rsplit_once("::");
                owner.is_some_and(|(of, _)| {
                    let owners = self.named_by(scope, of, Namespace::Type);
                    owners.iter().any(|def| matches!(def, Def::External(_)))
                })
            };
            if found.is_empty() && types.is_empty() && !is_method() {
                self.functions_named(scope, word)?;
            }
        }
        Ok(())
    }
}
