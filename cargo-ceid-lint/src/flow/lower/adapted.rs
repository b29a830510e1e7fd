//! Filters whose laws have another form, by ceid-core's `Adapted`: what the body feeds, the guard updates at the end of the
//! cycle. An update is counted where its input is first fed, because without an input no law runs, and a later one takes its place.

use std::collections::BTreeSet;

use super::{Builder, ClosureRef, Value};
use crate::flow::{Cause, Effect, GuardId, Place, RunBy, Var};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::ExprId;

/// How the law of an adapted filter runs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Adaptation {
    law: ClosureRef,
    /// Whether it runs only in cycles that feed it.
    is_fed: bool,
}

impl Builder<'_> {
    /// `Adapted::new(&mut filter, law)` and `Adapted::fed(&mut filter, law)`: another name for the filter.
    pub(super) fn adapt(&mut self, id: ExprId, function: &str, args: &[ExprId]) -> Value {
        let values = self.values(args);
        let [filter, law] = values.as_slice() else { return Value::default() };
        let span = self.span(id);
        let var = self.temporary(self.ty(id).clone(), span);
        self.set(var, &Value { place: filter.place.clone(), ..Value::default() }, span);
        if let Some(law) = law.closure {
            self.adapted.insert(var, Adaptation { law, is_fed: function == "fed" });
        }
        Value { place: Some(Place::var(var)), ..Value::default() }
    }

    /// A method of an adapted filter that is not one of the filter itself.
    pub(super) fn adapted_call(
        &mut self,
        id: ExprId,
        receiver: ExprId,
        method: &str,
        args: &[ExprId],
    ) -> Option<Value> {
        if !matches!((method, args.len()), ("feed", 1) | ("last_output", 0)) || !is_adapted(self.ty(receiver).peel()) {
            return None;
        }
        let value = self.expr(receiver);
        let given = self.values(args);
        let Some(place) = value.place.filter(|_| method == "feed" && self.at.is_some()) else {
            return Some(Value::default());
        };
        let var = place.base_var();
        let span = self.span(id);
        match var.and_then(|var| self.adaptation(var)) {
            Some(Adaptation { law, is_fed: true }) if var.is_some_and(|var| self.is_admitted(var)) => {
                let input = given.into_iter().next().unwrap_or_default();
                self.run_law(law, &[Value { place: Some(place), ..Value::default() }, input], args, span);
            }
            _ => {
                let cause = Cause::Code(format!("`{}`, which no guard is seen to hold", self.text(receiver)));
                self.emit(Effect::Unknown { places: vec![place], cause }, span);
            }
        }
        Some(Value::default())
    }

    /// A guard gets what lies at a place, which may be an adapted filter.
    pub(super) fn admit(&mut self, guard: GuardId, place: &Place, ty: &Ty, span: Span) {
        let Some(var) = place.base_var().filter(|_| is_adapted(ty.peel())) else { return };
        match self.adaptation(var) {
            Some(Adaptation { is_fed: true, .. }) => {
                self.admitted.insert(var);
            }
            Some(adaptation) => self.adapted_by.entry(guard).or_default().push((place.clone(), adaptation)),
            None => {
                let cause = Cause::Code("an adapted filter whose law is written elsewhere".to_owned());
                self.emit(Effect::Unknown { places: vec![place.clone()], cause }, span);
            }
        }
    }

    /// The end of a guard: the laws run that take no input.
    pub(super) fn run_adapted(&mut self, guard: GuardId, span: Span) {
        for (place, adaptation) in self.adapted_by.get(&guard).cloned().unwrap_or_default() {
            self.run_law(adaptation.law, &[Value { place: Some(place), ..Value::default() }], &[], span);
        }
    }

    /// Runs a law as a guard does.
    fn run_law(&mut self, law: ClosureRef, args: &[Value], fed: &[ExprId], span: Span) {
        let first = self.graph.nodes.len();
        self.inline_closure(law, args, span);
        let reads: Vec<_> = fed.iter().flat_map(|arg| self.reads_of(*arg)).collect();
        for node in &mut self.graph.nodes[first..] {
            node.span = span;
            if let Effect::Update(update) = &mut node.effect {
                update.run_by = if fed.is_empty() { RunBy::Guard } else { RunBy::GuardIfFed };
                update.fed.extend(reads.iter().cloned());
            }
        }
    }

    fn adaptation(&self, var: Var) -> Option<Adaptation> {
        self.origins(var).into_iter().find_map(|var| self.adapted.get(&var).copied())
    }

    /// Whether a guard that is alive holds what a variable leads to.
    fn is_admitted(&self, var: Var) -> bool {
        self.origins(var).iter().any(|var| self.admitted.contains(var))
    }

    /// A variable, and those that its value came from.
    fn origins(&self, var: Var) -> BTreeSet<Var> {
        let mut found = BTreeSet::from([var]);
        let mut open = vec![var];
        while let Some(var) = open.pop() {
            let from = self.graph.derived.iter().filter(|(own, _)| *own == var).map(|(_, from)| *from);
            open.extend(from.filter(|from| found.insert(*from)));
        }
        found
    }
}

/// Whether a type is ceid-core's.
pub(super) fn is_adapted(ty: &Ty) -> bool {
    matches!(ty, Ty::External(path, _) if path == crate::types::ADAPTED)
}
