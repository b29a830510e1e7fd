//! Filters whose laws have another form, by ceid-core's `Adapted`: what the body feeds, the guard updates at the end of the
//! cycle. An update is counted where its input is first fed, because without an input no law runs, and a later one takes its place.

use std::collections::BTreeSet;

use super::sources::{Item, Source};
use super::{Builder, ClosureRef, Value};
use crate::flow::{Cause, Effect, GuardId, Place, Rounds, RunBy, Var};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{Body, ExprId, ExprKind};

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

    /// `filters.each_mut().map(|filter| Adapted::fed(filter, law))`, or the same of a vector with `collect`: each filter of a
    /// collection by another name. `None` if the call is something else.
    pub(super) fn adapt_each(&mut self, id: ExprId, receiver: ExprId, method: &str, args: &[ExprId]) -> Option<Value> {
        let ty = self.ty(id);
        if !ty.element().is_some_and(is_adapted) {
            return None;
        }
        let body = self.body();
        let (elements, lend) = match (method, args, &body.expr(receiver).kind) {
            ("map", [lend], _) => (receiver, *lend),
            ("collect", [], ExprKind::MethodCall { receiver, method, args, .. }) if method == "map" => {
                (*receiver, *args.first()?)
            }
            _ => return None,
        };
        let ExprKind::MethodCall { receiver: collection, method, .. } = &body.expr(elements).kind else { return None };
        let (ExprKind::Closure(lend), "each_mut" | "iter_mut") = (&body.expr(lend).kind, method.as_str()) else {
            return None;
        };
        let [(param, _)] = lend.params.as_slice() else { return None };
        let ExprKind::Call { callee, args } = &body.expr(bare_tail(body, lend.body)).kind else { return None };
        let (ExprKind::Path(path), [filter, law]) = (&body.expr(*callee).kind, args.as_slice()) else { return None };
        let lent = self.typed().expr_local.get(&unborrowed(body, *filter));
        if lent.is_none() || lent != self.typed().pat_local.get(param) {
            return None;
        }
        let (ty, span) = (ty.clone(), self.span(id));
        let place = self.expr(*collection).place?;
        let law = self.expr(*law).closure?;
        let var = self.temporary(ty, span);
        self.set(var, &Value { place: Some(place), ..Value::default() }, span);
        self.adapted.insert(var, Adaptation { law, is_fed: path.last() == "fed" });
        Some(Value { place: Some(Place::var(var)), ..Value::default() })
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
        let own = ty.peel().element().unwrap_or(ty.peel());
        let Some(var) = place.base_var().filter(|_| is_adapted(own)) else { return };
        match self.adaptation(var) {
            Some(Adaptation { is_fed: true, .. }) => {
                self.admitted.insert(var);
            }
            Some(adaptation) => {
                let rounds = ty.peel().element().map(|_| match ty.peel() {
                    Ty::Array(_, length) => length.value.map_or(Rounds::Bounded, Rounds::Constant),
                    _ => Rounds::Bounded,
                });
                self.adapted_by.entry(guard).or_default().push((place.clone(), rounds, adaptation));
            }
            None => {
                let cause = Cause::Code("an adapted filter whose law is written elsewhere".to_owned());
                self.emit(Effect::Unknown { places: vec![place.clone()], cause }, span);
            }
        }
    }

    /// The end of a guard: the laws run that take no input.
    pub(super) fn run_adapted(&mut self, guard: GuardId, span: Span) {
        for (place, rounds, Adaptation { law, .. }) in self.adapted_by.get(&guard).cloned().unwrap_or_default() {
            match rounds {
                None => self.run_law(law, &[Value { place: Some(place), ..Value::default() }], &[], span),
                Some(rounds) => {
                    let source = Source { item: Item::Element(place), rounds, ..Source::bounded() };
                    self.run_by_guard(&[], span, |this| this.closure_loop(law, source, span));
                }
            }
        }
    }

    /// Runs a law as a guard does.
    fn run_law(&mut self, law: ClosureRef, args: &[Value], fed: &[ExprId], span: Span) {
        self.run_by_guard(fed, span, |this| drop(this.inline_closure(law, args, span)));
    }

    /// What runs here is run by a guard.
    fn run_by_guard(&mut self, fed: &[ExprId], span: Span, run: impl FnOnce(&mut Self)) {
        let first = self.graph.nodes.len();
        run(self);
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

/// An expression without the blocks that only give it back.
fn bare_tail(body: &Body, id: ExprId) -> ExprId {
    match &body.expr(id).kind {
        ExprKind::Block(block) if block.stmts.is_empty() => block.tail.map_or(id, |tail| bare_tail(body, tail)),
        _ => id,
    }
}

/// What is lent: `filter` in `&mut **filter`.
fn unborrowed(body: &Body, id: ExprId) -> ExprId {
    match &body.expr(id).kind {
        ExprKind::Reference { value, .. } | ExprKind::Deref(value) => unborrowed(body, *value),
        _ => id,
    }
}
