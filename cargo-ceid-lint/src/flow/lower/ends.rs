//! How guards end before their scope does: dropped, never bound, forgotten.

use super::{Builder, Value};
use crate::flow::{Effect, GuardId, Place};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind};

impl Builder<'_> {
    /// A value that a statement drops at once.
    pub(super) fn discard(&mut self, expr: ExprId, value: &Value, span: Span) {
        self.note_dropped_state(value);
        if self.at.is_some()
            && (self.destroyed_by(value).is_none() || value.leaves_by.is_some())
            && !self.is_guard_value(expr, value)
        {
            return self.drop_now(expr, value, span);
        }
        if self.at.is_some() && self.is_guard_value(expr, value) && !self.is_bound(value) {
            self.mark_dropped(expr, value, span, "it is never bound to a name");
        }
    }

    /// `let _ = value;`
    pub(super) fn discard_wild(&mut self, expr: ExprId, value: &Value, span: Span) {
        self.note_dropped_state(value);
        if self.at.is_some() && self.is_guard_value(expr, value) && !self.is_bound(value) {
            return self.mark_dropped(expr, value, span, "`let _` drops it at once");
        }
        self.drop_unnamed(expr, value);
    }

    /// A state that a law gave back is dropped by the statement that runs the law.
    fn note_dropped_state(&mut self, value: &Value) {
        let Some(var) = value.place.as_ref().and_then(Place::base_var).filter(|var| self.advanced.contains(var)) else {
            return;
        };
        for node in &mut self.graph.nodes {
            if let Effect::Advance(advance) = &mut node.effect
                && advance.after.base_var() == Some(var)
            {
                advance.is_dropped = true;
            }
        }
    }

    /// A value that is only asked whether it is there: `control.cycle().is_some()` drops the guard at once.
    pub(super) fn discard_asked(&mut self, expr: ExprId, value: &Value) {
        if matches!(self.body().expr(expr).kind, ExprKind::MethodCall { .. }) && self.is_guard(expr) {
            self.discard(expr, value, self.span(expr));
        }
    }

    pub(super) fn is_bound(&self, value: &Value) -> bool {
        let var = value.place.as_ref().and_then(Place::base_var);
        var.and_then(|var| self.guards_of.get(&var)).is_some_and(|id| {
            let info = &self.graph.guards[id.0 as usize];
            info.name.is_some() || info.forgotten.is_some() || info.dropped.is_some()
        })
    }

    pub(super) fn mark_dropped(&mut self, expr: ExprId, value: &Value, span: Span, how: &str) {
        if let Some(guard) = self.guard_of(expr, value) {
            self.drop_early(guard, span, how);
        }
    }

    /// A guard is dropped before the end of its cycle.
    pub(super) fn drop_early(&mut self, guard: GuardId, span: Span, how: &str) {
        self.graph.guards[guard.0 as usize].dropped.get_or_insert_with(|| (span, how.to_owned()));
        self.end_now(guard, span);
    }

    /// Ends a guard before its scope does.
    pub(super) fn end_now(&mut self, guard: GuardId, span: Span) {
        self.ended.insert(guard);
        self.end_guard(guard, span);
        if let Some(alive) = self.alive.get(&guard).copied() {
            self.set(alive, &Value { head: Some("false".to_owned()), ..Value::default() }, span);
        }
    }

    /// `drop(value)`, or a call that is seen to do that: at the end of the cycle it changes nothing.
    pub(super) fn drop_value(&mut self, call: ExprId, expr: ExprId, value: &Value, how: &str) {
        if self.at.is_none() || matches!(self.ty(expr), Ty::Ref(..)) {
            return;
        }
        let span = self.span(call);
        if !self.is_guard(expr) {
            return self.drop_now(expr, value, span);
        }
        let behind = self.frames[self.frame].last.get(&call);
        if behind.is_none_or(|values| values.iter().any(|value| self.names_filter(*value))) {
            return self.mark_dropped(expr, value, span, how);
        }
        if let Some(guard) = self.guard_of(expr, value) {
            self.end_now(guard, span);
        }
    }

    /// Whether a filter is named anywhere in an expression.
    fn names_filter(&self, id: ExprId) -> bool {
        self.body().within(id).any(|id| self.program.index.filter_spec(self.ty(id).peel()).is_some())
    }

    /// A value whose destructor will never run.
    pub(super) fn forget_value(&mut self, expr: ExprId, value: &Value, span: Span, how: &str) {
        if self.at.is_none() {
            return;
        }
        if let Some(guard) = self.destroyed_by(value) {
            return self.release(guard, span);
        }
        let Some(guard) = self.guard_of(expr, value) else { return };
        self.graph.guards[guard.0 as usize].forgotten = Some((span, how.to_owned()));
        // What it holds is not reached by it any more on this way.
        self.let_go(guard, span);
        self.end_now(guard, span);
    }

    /// A guard has nothing any more.
    pub(super) fn let_go(&mut self, guard: GuardId, span: Span) {
        for held in self.graph.guards[guard.0 as usize].holds.clone() {
            self.set(held, &Value::default(), span);
        }
    }
}
