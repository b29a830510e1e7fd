//! Values that become others by a conversion of the analysed code: `idle.into()`.

use super::{Builder, Value};
use crate::flow::{Cause, Effect, Place};
use crate::index::{Owner, Ty};
use crate::syntax::tree::ExprId;

impl Builder<'_> {
    /// `idle.into()`: the analysed code that makes something else of a value with a filter, by the only impl that takes it.
    pub(super) fn converted(&mut self, id: ExprId, receiver: ExprId, method: &str, value: &Value) -> Option<Value> {
        let ty = self.ty(receiver).clone();
        let is_own = matches!(ty, Ty::Adt(..)) && self.may_hold_filter(&ty) && value.is_owned;
        let place = value.place.clone().filter(|_| method == "into" && is_own && self.at.is_some())?;
        let index = self.program.index;
        match index.conversions(&ty).as_slice() {
            [] => None,
            [target] => {
                let result = self.emit_call(id, &[*target], &[receiver], std::slice::from_ref(value), None);
                let Owner::Impl(owner) = index.function(*target).owner else { return None };
                self.graph.vars[result.0 as usize].ty = index.impl_def(owner).self_ty.clone();
                Some(Value {
                    place: Some(Place::var(result)),
                    is_owned: true,
                    same_as: Some(result),
                    ..Value::default()
                })
            }
            _ => {
                let cause = Cause::Call(self.text(id));
                self.emit(Effect::Unknown { places: vec![place], cause }, self.span(id));
                Some(Value::default())
            }
        }
    }
}
