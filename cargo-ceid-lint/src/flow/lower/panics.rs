//! Panics that are caught: what follows in the code that panics is left out, and the cycle goes on.

use rustc_hash::FxHashSet;

use super::{Builder, ClosureRef, Frame, Value};
use crate::flow::{Cause, Effect, Place};
use crate::index::{FunctionId, Ty};
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
        let may_panic = may_panic || self.may_fail_before_a_law(closure);
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

    /// Whether a closure asks something unseen, or for an element that need not be there, before it may run a law.
    fn may_fail_before_a_law(&self, closure: ClosureRef) -> bool {
        let Frame { body, typed, .. } = &self.frames[closure.frame];
        let is_law =
            |id: &ExprId| matches!(typed.callees.get(id), Some(Callee::Resolved(call)) if self.may_run_law(call, 0));
        let may_fail = |id: &ExprId| match (&body.expr(*id).kind, typed.callees.get(id)) {
            (ExprKind::Index { index, .. }, _) => !matches!(body.expr(*index).kind, ExprKind::Literal(_)),
            (ExprKind::Call { .. }, Some(Callee::Parameter(_) | Callee::Unknown) | None) => true,
            (ExprKind::MethodCall { .. } | ExprKind::Call { .. }, Some(Callee::Resolved(call))) => {
                let is_seen = |target: &FunctionId| self.program.index.function(*target).function.body.is_some();
                let is_any = matches!(call.self_ty.peel(), Ty::Opaque(_) | Ty::Param(_));
                call.law.is_none() && (is_any && call.has_receiver || !call.targets.iter().any(is_seen))
            }
            _ => false,
        };
        // What an expression is made of stands before it.
        let last = body.within(closure.expr).filter(is_law).max();
        last.is_some_and(|last| body.within(closure.expr).any(|id| id < last && may_fail(&id)))
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
