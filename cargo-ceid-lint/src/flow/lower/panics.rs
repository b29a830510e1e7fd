//! Panics that are caught: what follows in the code that panics is left out, and the cycle goes on.

use rustc_hash::FxHashSet;

use super::{Builder, ClosureRef, Value};
use crate::flow::{Cause, Effect, Place};
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, MacroKind};
use crate::types::Callee;

impl Builder<'_> {
    /// Runs a closure of which a panic is caught and goes no further. Only what it or a function that it calls is there to raise is
    /// meant to be caught: a panic further down is that of a broken program, whose ways owe nothing.
    pub(super) fn swallow_panics(
        &mut self,
        closure: ClosureRef,
        span: Span,
        run: impl FnOnce(&mut Self) -> Value,
    ) -> Value {
        let frame = &self.frames[closure.frame];
        let place = frame.body.expr(closure.expr).span;
        let may_panic =
            self.reaches(frame.body, frame.typed, place, 1, &mut FxHashSet::default(), &|_, kind| panics(kind));
        if !may_panic || self.at.is_none() {
            return run(self);
        }
        let before = self.emit(Effect::Nothing, span);
        let first = self.graph.nodes.len();
        let value = run(self);
        let places: Vec<Place> = self.graph.nodes[first..].iter().flat_map(|node| updated_at(&node.effect)).collect();
        let after = self.add_node(Effect::Nothing, span);
        self.jump(after);
        self.resume(before);
        if !places.is_empty() {
            let cause = Cause::Code("where a panic that is caught leaves the code".to_owned());
            self.emit(Effect::Unknown { places, cause }, span);
        }
        self.jump(after);
        self.resume(after);
        value
    }

    /// Whether what a call catches is raised again: `catch_unwind(…).unwrap()`, `resume_unwind(panic)`.
    pub(super) fn is_raised_again(&self, call: ExprId) -> bool {
        let (body, typed) = (self.body(), self.typed());
        let resumes = |id: u32| matches!(typed.callees.get(&ExprId(id)), Some(Callee::External(path)) if path.ends_with("::resume_unwind"));
        (0u32..).take(body.exprs.len()).any(resumes) || self.is_taken_by(call, |id| self.unwrapped(id))
    }
}

/// What a node may update.
fn updated_at(effect: &Effect) -> Vec<Place> {
    match effect {
        Effect::Update(update) => vec![update.place.clone()],
        Effect::Call(site) => {
            site.args.iter().filter(|arg| !arg.is_shared).filter_map(|arg| arg.place.clone()).collect()
        }
        _ => Vec::new(),
    }
}

/// Whether an expression is there to panic, as far as its form tells.
fn panics(kind: &ExprKind) -> bool {
    match kind {
        ExprKind::Macro(call) => {
            matches!(call.kind, MacroKind::Diverges(_) | MacroKind::Assert(..) | MacroKind::AssertCompare(..))
        }
        ExprKind::MethodCall { method, .. } => matches!(method.as_str(), "unwrap" | "expect"),
        _ => false,
    }
}
