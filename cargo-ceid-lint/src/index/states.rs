//! States of laws that have them in an argument: `fir(&mut state, x)`. The signatures of the laws tell which types they have.

use super::{Def, FilterSpec, FunctionId, Index, LawGroup, Owner, Subject, Ty};
use crate::config::InstancePlace;

/// The type of the states of a law.
#[derive(Clone, Debug)]
pub(super) struct StateType {
    ty: Ty,
    /// The number of the law.
    spec: usize,
    /// Whether the law gives back the state after it instead of changing the one before.
    is_returned: bool,
}

impl Index {
    /// The states of the laws that are known now.
    pub(super) fn find_states(&self) -> Vec<StateType> {
        let mut found: Vec<StateType> = Vec::new();
        for (spec, known) in self.specs.iter().enumerate().filter(|(_, spec)| spec.is_sampled) {
            for law in self.bodies_of(known) {
                let scope = self.scope_of(law);
                let function = &self.function(law).function;
                let mut params = function.params.iter().map(|ty| self.lower(ty, &scope).peel().clone());
                let (ty, is_returned) = match known.instance {
                    InstancePlace::Receiver => continue,
                    InstancePlace::Argument(number) => (params.nth(number as usize), false),
                    InstancePlace::Returned => {
                        let output = self.lower(&function.output, &scope);
                        let is_given = |ty: &Ty| handed(&output, ty).is_some();
                        // A state may have the law itself.
                        let own = scope.self_ty.clone().filter(|ty| function.receiver.is_some() && is_given(ty));
                        (own.or_else(|| params.filter(is_given).min_by_key(is_number)), true)
                    }
                };
                found.extend(ty.map(|ty| StateType { ty, spec, is_returned }));
            }
        }
        // Where several laws share a type, the one with the most halves tells how many there are.
        found.sort_by_key(|state| std::cmp::Reverse(self.specs[state.spec].law.len()));
        found
    }

    /// Makes the functions that change one state the parts of one law: those of one entry are alternatives, those of several entries
    /// are a half each.
    pub(super) fn share_laws(&mut self) {
        let mut laws: Vec<(&Ty, Vec<LawGroup>, Vec<usize>)> = Vec::new();
        // The entry that was written first stands last.
        for state in self.states.iter().filter(|state| !state.is_returned).rev() {
            let Some(own) = self.own_group(state.spec) else { continue };
            let is_named = matches!(&state.ty, Ty::Adt(..))
                || matches!(&state.ty, Ty::External(path, _) if !path.starts_with("std::"));
            match laws.iter_mut().find(|(ty, ..)| is_named && is_like(ty, &state.ty)) {
                Some((_, groups, specs)) => {
                    if !groups.contains(&own) {
                        groups.push(own);
                    }
                    specs.push(state.spec);
                }
                None => laws.push((&state.ty, vec![own], vec![state.spec])),
            }
        }
        let laws: Vec<(Vec<LawGroup>, Vec<usize>)> =
            laws.into_iter().map(|(_, groups, specs)| (groups, specs)).collect();
        for (mut groups, specs) in laws {
            // Functions of the entry that have other states have no part in it.
            let names: Vec<String> = specs.iter().filter_map(|spec| self.own_name(*spec)).map(str::to_owned).collect();
            for group in &mut groups {
                group.methods.retain(|name| names.contains(name));
            }
            for spec in specs {
                self.specs[spec].law.clone_from(&groups);
            }
        }
    }

    /// The part of a law that its own entry names, if a function is the law.
    fn own_group(&self, spec: usize) -> Option<LawGroup> {
        let name = self.own_name(spec)?;
        self.specs[spec].law.iter().find(|group| group.methods.iter().any(|own| own == name)).cloned()
    }

    /// The name of the function that a law is.
    fn own_name(&self, spec: usize) -> Option<&str> {
        match &self.specs[spec].subject {
            Subject::Function(def) => self.name_of_law(def),
            _ => None,
        }
    }

    fn name_of_law<'a>(&'a self, def: &'a Def) -> Option<&'a str> {
        match def {
            Def::Function(id) => Some(&self.function(*id).name),
            Def::External(path) => path.rsplit("::").next(),
            _ => None,
        }
    }

    /// Which part of the law of a state a function runs.
    #[must_use]
    pub fn group_of(&self, spec: &FilterSpec, def: &Def) -> usize {
        self.name_of_law(def).and_then(|name| spec.group(name)).unwrap_or(0)
    }

    /// The functions that a law runs, as far as they are read.
    fn bodies_of(&self, spec: &FilterSpec) -> Vec<FunctionId> {
        let methods = spec.law.iter().flat_map(|group| &group.methods);
        match &spec.subject {
            Subject::Function(Def::Function(id)) => vec![*id],
            Subject::Type(id) => {
                let owners = methods.flat_map(|name| self.methods(&self.bare(*id), name));
                owners.filter_map(|owner| owner.function()).collect()
            }
            Subject::Trait(name) => methods.flat_map(|method| self.implementations(name, method)).collect(),
            _ => Vec::new(),
        }
    }

    /// What is known of the law whose state has this type. Numbers and arrays of them have other uses, too.
    #[must_use]
    pub fn state_spec(&self, ty: &Ty) -> Option<&FilterSpec> {
        let is_one = |state: &&StateType| match (&state.ty, ty) {
            (Ty::Adt(own, _), Ty::Adt(id, _)) => own == id,
            (Ty::External(own, _), Ty::External(path, _)) => own == path && !path.starts_with("std::"),
            _ => false,
        };
        self.states.iter().filter(|state| !state.is_returned).find(is_one).map(|state| &self.specs[state.spec])
    }

    /// The functions that are laws of states of a type of the analysed code: each with the number of the parameter in which it has
    /// the state, and which half of the law it runs.
    #[must_use]
    pub fn laws_of_state(&self, ty: &Ty) -> Vec<(FunctionId, usize, usize)> {
        let Ty::Adt(id, _) = ty else { return Vec::new() };
        let own =
            self.states.iter().filter(|state| !state.is_returned && matches!(state.ty, Ty::Adt(own, _) if own == *id));
        let law = |state: &StateType| match &self.specs[state.spec].subject {
            Subject::Function(def @ Def::Function(law)) => {
                Some((*law, self.state_parameter(*law)?, self.group_of(&self.specs[state.spec], def)))
            }
            _ => None,
        };
        own.filter_map(law).collect()
    }

    /// The functions that are laws of states of a type of the analysed code, those of other types among them.
    #[must_use]
    pub fn bodies_of_state(&self, ty: &Ty) -> Vec<FunctionId> {
        let is_one = |state: &&StateType| match (&state.ty, ty) {
            (Ty::Adt(own, _), Ty::Adt(id, _)) => own == id && !state.is_returned,
            _ => false,
        };
        self.states.iter().filter(is_one).flat_map(|state| self.bodies_of(&self.specs[state.spec])).collect()
    }

    /// What is known of the law that gives back its state, where a value of the type is one.
    #[must_use]
    pub fn returned_spec(&self, ty: &Ty) -> Option<&FilterSpec> {
        let mut returned = self.states.iter().filter(|state| state.is_returned);
        returned.find(|state| is_like(&state.ty, ty)).map(|state| &self.specs[state.spec])
    }

    /// Whether a value of the type could be the state of a law.
    #[must_use]
    pub fn may_be_state(&self, ty: &Ty) -> bool {
        self.states.iter().any(|state| is_like(&state.ty, ty))
    }

    /// The parameter of a law in which its state is, by its number among all parameters.
    #[must_use]
    pub fn state_parameter(&self, id: FunctionId) -> Option<usize> {
        let def = self.function(id);
        let spec = match def.owner {
            Owner::Impl(owner) => {
                self.law_spec(&self.impl_def(owner).self_ty).filter(|spec| spec.group(&def.name).is_some())
            }
            _ => self.function_spec(&Def::Function(self.origin(id))),
        };
        match spec?.instance {
            InstancePlace::Argument(number) => Some(number as usize + usize::from(def.function.receiver.is_some())),
            _ => None,
        }
    }
}

/// Whether values of the type are plain numbers, which are seldom states where there is anything else.
#[must_use]
pub fn is_number(ty: &Ty) -> bool {
    matches!(ty, Ty::Int | Ty::Float)
}

/// Where a state of the type is in what a function gives back: the part of a tuple, or no part if it is all of it. What may
/// fail gives it back where it does not.
#[must_use]
pub fn handed(output: &Ty, state: &Ty) -> Option<Option<usize>> {
    match output {
        Ty::External(path, args) if matches!(path.rsplit("::").next(), Some("Result" | "Option")) => {
            handed(args.first()?, state)
        }
        Ty::Tuple(parts) => parts.iter().position(|part| is_like(part, state)).map(Some),
        _ => is_like(output, state).then_some(None),
    }
}

/// Whether two types are the same, as far as both are known.
pub(super) fn is_like(state: &Ty, ty: &Ty) -> bool {
    let all = |left: &[Ty], right: &[Ty]| {
        left.len() == right.len() && left.iter().zip(right).all(|(left, right)| is_like(left, right))
    };
    match (state, ty) {
        (Ty::Array(left, _) | Ty::Slice(left), Ty::Array(right, _) | Ty::Slice(right)) => is_like(left, right),
        (Ty::Tuple(left), Ty::Tuple(right)) => all(left, right),
        (Ty::Adt(left, _), Ty::Adt(right, _)) => left == right,
        (Ty::External(left, own), Ty::External(right, args)) => left == right && all(own, args),
        _ => state == ty && matches!(ty, Ty::Int | Ty::Float),
    }
}
