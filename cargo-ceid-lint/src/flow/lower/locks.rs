//! Closures that get what is locked for them.

use super::{Builder, ClosureRef, Value};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind};

impl Builder<'_> {
    /// `(a, b).lock(|a, b| …)`: several resources are locked at once, and each is lent under the name that it has.
    pub(super) fn lock_each(&mut self, receiver: ExprId, method: &str, args: &[ExprId], span: Span) -> Option<Value> {
        let body = self.body();
        let (ExprKind::Tuple(parts), "lock", [arg]) = (&body.expr(receiver).kind, method, args) else { return None };
        if !matches!(body.expr(*arg).kind, ExprKind::Closure(_)) {
            return None;
        }
        let parts: Vec<Value> = self.values(parts).into_iter().map(|part| Value { is_owned: false, ..part }).collect();
        let closure = self.expr(*arg).closure?;
        Some(self.inline_closure(closure, &parts, span))
    }

    /// A closure gets what is locked. A tuple of resources is locked as a whole, and its parts are lent one by one.
    pub(super) fn run_locked(&mut self, closure: ClosureRef, receiver: ExprId, value: &Value, span: Span) -> Value {
        let payload = Value { is_owned: false, ..value.clone() };
        let payloads = match (self.ty(receiver).peel(), &value.place) {
            (Ty::Tuple(parts), Some(place)) => (0..parts.len())
                .map(|at| Value { place: Some(place.field(&at.to_string())), ..payload.clone() })
                .collect(),
            _ => vec![payload],
        };
        self.inline_closure(closure, &payloads, span)
    }
}
