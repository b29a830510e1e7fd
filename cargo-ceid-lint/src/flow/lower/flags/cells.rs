//! States in cells, which are changed through shared references: `self.mode.get()`, `*self.mode.borrow()`.

use super::super::{Builder, Value};
use super::is_flag;
use crate::flow::{Effect, Place, Var};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind};

impl Builder<'_> {
    /// The place of the state that an expression reads out of a cell as it is.
    pub(in crate::flow::lower) fn state_in_cell(&mut self, id: ExprId) -> Option<Place> {
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::MethodCall { receiver, method, args, .. } if self.is_state(self.ty(id)) => {
                let reads = match (method.as_str(), args.len()) {
                    ("get", 0) => self.is_cell(*receiver),
                    ("load", 1) => is_flag(self.ty(*receiver)) && self.is_exclusive(*receiver),
                    _ => false,
                };
                if reads { self.static_place(*receiver) } else { None }
            }
            ExprKind::Deref(inner) if self.is_state(self.ty(id)) || *self.ty(id) == Ty::Int => {
                self.borrowed_cell(*inner)
            }
            _ => None,
        }
    }

    /// The place of the cell of which an expression borrows what it holds, to read it.
    pub(in crate::flow::lower) fn borrowed_cell(&mut self, id: ExprId) -> Option<Place> {
        let ExprKind::MethodCall { receiver, method, args, .. } = &self.body().expr(id).kind else { return None };
        let borrows = method == "borrow"
            && args.is_empty()
            && self.ty(*receiver).peel().external_name() == Some("RefCell")
            && !self.may_hold_filter(self.ty(*receiver));
        if borrows { self.static_place(*receiver) } else { None }
    }

    /// Whether nothing else can change what a place holds while this code has it: no static, and nothing behind a shared handle.
    pub(in crate::flow::lower) fn is_exclusive(&self, id: ExprId) -> bool {
        let ty = self.ty(id);
        let is_shared = matches!(ty, Ty::Ref(false, _)) || self.program.index.is_handle(ty);
        !is_shared
            && match &self.body().expr(id).kind {
                ExprKind::Path(_) => self.typed().expr_local.contains_key(&id),
                ExprKind::Field { base, .. } | ExprKind::Index { base, .. } | ExprKind::Deref(base) => {
                    self.is_exclusive(*base)
                }
                _ => false,
            }
    }

    /// A variable with the state that a cell held before something else is put there.
    pub(in crate::flow::lower) fn taken_from_cell(&mut self, place: &Place, ty: Ty, span: Span) -> Var {
        let taken = self.temporary(ty, span);
        let old = Value { place: Some(place.clone()), ..Value::default() };
        self.set(taken, &old, span);
        self.note_taken(taken, &old);
        taken
    }

    /// Notes that the last node gives a cell the state that a value is.
    pub(in crate::flow::lower) fn note_put_in_cell(&mut self, given: &Value, expr: ExprId) {
        if !self.is_state(self.ty(expr)) {
            return;
        }
        if let Some(at) = self.at
            && let Effect::Write(write) = &mut self.graph.nodes[at.0 as usize].effect
        {
            write.same_as = given.same_as;
        }
        self.note_copy(expr);
    }
}
