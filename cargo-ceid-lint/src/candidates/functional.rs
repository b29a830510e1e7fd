//! Filters that give back the next state: `let next = kf.predict(&state);`

use std::collections::BTreeMap;

use super::halves::groups;
use super::judge::LEAST_WEIGHT;
use super::laws::{Draft, Finder, Found};
use super::words::{law_strength, type_strength};
use super::{Reason, Subject, Uses};
use crate::config::{InstancePlace, Receiver as Taken, TimeBase};
use crate::flow::takes_step;
use crate::index::{FunctionId, Namespace, Ty, TypeId};
use crate::syntax::tree::Receiver;

impl Finder<'_> {
    /// Types with the name of a filter whose methods take a state and give back one, and are called.
    pub(super) fn find_functional(&mut self) {
        let index = self.program.index;
        let laws = self.laws();
        for (ty, methods) in self.types() {
            let def = index.type_def(ty);
            if type_strength(&def.name) < 2 {
                continue;
            }
            let mut by_state: BTreeMap<TypeId, Vec<FunctionId>> = BTreeMap::new();
            for id in methods.into_iter().filter(|id| !laws.contains_key(id)) {
                let is_law = law_strength(&index.function(id).name) > 0;
                if let Some(state) = self.state_given_back(id).filter(|state| is_law && *state != ty) {
                    by_state.entry(state).or_default().push(id);
                }
            }
            let uses = |ids: &[FunctionId]| ids.iter().fold(Uses::default(), |uses, id| uses.and(self.calls.uses(*id)));
            let Some((state, ids)) = by_state.into_iter().max_by_key(|(_, ids)| uses(ids)) else { continue };
            let uses = uses(&ids);
            if uses.calls == 0 || self.found.iter().any(|found| found.place == def.span) {
                continue;
            }
            let mut names: Vec<String> = ids.iter().map(|id| index.function(*id).name.clone()).collect();
            names.sort();
            names.dedup();
            let is_timed = ids.iter().any(|id| takes_step(index, *id));
            let gives = Reason::GivesBack(names[0].clone(), index.type_def(state).name.clone());
            self.found.push(Found {
                name: def.name.clone(),
                place: def.span,
                path: self.path_to(def.module, &def.name, def.span, Namespace::Type),
                draft: Draft {
                    subject: Subject::Type,
                    law: groups(&names, &[]),
                    instance: InstancePlace::Returned,
                    receiver: Taken::Shared,
                    resets: Vec::new(),
                    partial_resets: Vec::new(),
                    key: None,
                    time_base: if is_timed { TimeBase::Passed } else { TimeBase::Fixed },
                    reasons: vec![gives, Reason::Named(def.name.clone())],
                    uses,
                    weight: LEAST_WEIGHT + i32::from(uses.in_cycles > 0) + i32::from(names.len() > 1),
                    is_plain: false,
                },
                laws: ids,
            });
        }
    }

    /// The type of the state that a method takes and gives back, both without changing what is there.
    fn state_given_back(&self, id: FunctionId) -> Option<TypeId> {
        let index = self.program.index;
        let function = &index.function(id).function;
        let scope = index.scope_of(id);
        let output = index.lower(&function.output, &scope);
        let given = match output.peel() {
            Ty::Adt(given, _) => *given,
            Ty::External(path, args) if path.ends_with("::Option") || path.ends_with("::Result") => {
                match args.first().map(Ty::peel) {
                    Some(Ty::Adt(given, _)) => *given,
                    _ => return None,
                }
            }
            _ => return None,
        };
        let is_state = |ty: &Ty| matches!(ty.peel(), Ty::Adt(own, _) if *own == given);
        let takes = function.params.iter().any(|param| is_state(&index.lower(param, &scope)));
        (function.receiver == Some(Receiver::Shared) && takes).then_some(given)
    }
}
