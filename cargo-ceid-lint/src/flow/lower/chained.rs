//! Methods that give their filter back, so that another one is called on what they give: `pid.setpoint(3.0).update(x)`.

use super::laws::Law;
use super::{Builder, Value};
use crate::flow::{Cause, Effect, Place, Transfer};
use crate::index::Ty;
use crate::syntax::tree::ExprId;
use crate::types::Resolved;

impl Builder<'_> {
    /// What a reset gives, where that is its filter: what it gives by value may be a new one, where that can be seen.
    pub(super) fn chained(&mut self, id: ExprId, resolved: &Resolved, place: &Place) -> Value {
        let is_same = is_lent(self.ty(id)) || resolved.targets.is_empty();
        if is_same && gives(self.ty(id), &resolved.self_ty) {
            self.itself(id, place)
        } else {
            self.given_else(id, place)
        }
    }

    /// The same for a method without any body: one that is given something gives its filter back. What else gives something that
    /// the law is called on may give the filter or a part of it.
    pub(super) fn chained_unread(&mut self, id: ExprId, resolved: &Resolved, place: &Place, is_given: bool) -> Value {
        if self.called_name(id) == "clone" {
            return Value::default();
        }
        if !gives(self.ty(id), &resolved.self_ty) {
            return self.given_else(id, place);
        }
        let is_signed = resolved.owner.is_some();
        if is_signed || is_given {
            return self.itself(id, place);
        }
        self.perhaps_itself(id, place)
    }

    /// What a method gives that is not the receiver by its type: a filter that it lends may lie in it.
    fn given_else(&mut self, id: ExprId, place: &Place) -> Value {
        let lends_filter = is_lent(self.ty(id)) && self.program.index.holds_filter(self.ty(id));
        if lends_filter { self.perhaps_itself(id, place) } else { Value::default() }
    }

    /// What a law without any body gives that another law is called on.
    pub(super) fn chained_law(&mut self, id: ExprId, law: &Law<'_>, receiver: ExprId, place: &Place) -> Option<Value> {
        let self_ty = self.ty(receiver).peel().clone();
        if !law.targets.is_empty() || !gives(self.ty(id), &self_ty) {
            return None;
        }
        let is_signed = !matches!(self_ty, Ty::External(..));
        Some(if is_signed { self.itself(id, place) } else { self.perhaps_itself(id, place) })
    }

    fn itself(&self, id: ExprId, place: &Place) -> Value {
        let leaves_by = (!is_lent(self.ty(id))).then_some(Transfer::Move);
        Value { place: Some(place.clone()), leaves_by, ..Value::default() }
    }

    fn perhaps_itself(&mut self, id: ExprId, place: &Place) -> Value {
        let cause = Cause::Call(self.text(id));
        self.emit(Effect::Unknown { places: vec![place.clone()], cause }, self.span(id));
        Value::default()
    }
}

/// Whether a result may be the receiver itself, lent or by value.
fn gives(output: &Ty, self_ty: &Ty) -> bool {
    match output.peel() {
        Ty::External(path, args) if is_fallible(path) => args.first().is_some_and(|inner| gives(inner, self_ty)),
        ty => ty == self_ty.peel(),
    }
}

/// Whether a result is a reference, or one where it is there at all.
fn is_lent(output: &Ty) -> bool {
    match output {
        Ty::External(path, args) if is_fallible(path) => args.first().is_some_and(is_lent),
        ty => matches!(ty, Ty::Ref(..)),
    }
}

fn is_fallible(path: &str) -> bool {
    matches!(path.rsplit("::").next(), Some("Result" | "Option"))
}
