//! Raw pointers to filters: whoever has one may update what it leads to at any time.

use super::{Builder, Value};
use crate::flow::Cause;
use crate::index::Ty;
use crate::syntax::tree::{ExprId, ExprKind};

impl Builder<'_> {
    /// A pointer to what an expression names goes where it is not followed.
    pub(super) fn keep_pointed(&mut self, expr: ExprId, value: &Value) {
        if let Some(place) = value.place.clone().filter(|_| self.may_hold_filter(self.ty(expr))) {
            self.graph.kept.push((place, Cause::Code("a raw pointer".to_owned())));
        }
    }

    /// A place has got a pointer: what others reach as well, a static or a field of what the function was given, hands it on.
    pub(super) fn keep_assigned_pointer(&mut self, target: ExprId, source: ExprId, value: &Value) {
        if !matches!(self.ty(target), Ty::Pointer(_)) {
            return;
        }
        let base = self.static_place(target).and_then(|place| place.base_var());
        if base.is_none_or(|var| self.graph.var(var).param.is_some()) {
            self.keep_pointed(source, value);
        }
    }

    /// Whether a call gives a shared pointer what it is to lead to: `CURRENT.store(&mut kf, Ordering::Release)`.
    pub(super) fn stores_pointer(&self, call: ExprId) -> bool {
        let ExprKind::MethodCall { receiver, .. } = &self.body().expr(call).kind else { return false };
        matches!(self.ty(*receiver).peel(), Ty::External(path, _) if path.ends_with("::AtomicPtr"))
    }

    /// Whether a cast makes a pointer to another type of what a pointer of an unknown type names: the value behind it is
    /// another one than the fields of that type would tell.
    pub(super) fn is_reinterpreted(&self, id: ExprId, inner: ExprId) -> bool {
        let is_known = |ty: &Ty| match ty {
            Ty::Pointer(to) => matches!(to.peel(), Ty::Adt(..) | Ty::Array(..) | Ty::Slice(_) | Ty::Param(_)),
            ty => matches!(ty, Ty::Ref(..)),
        };
        matches!(self.ty(id), Ty::Pointer(_)) && is_known(self.ty(id)) && !is_known(self.ty(inner))
    }

    /// Whether what is written through a pointer to a filter gets a type that tells nothing of it: `self as *mut Self as *mut c_void`.
    pub(super) fn loses_type(&self, id: ExprId, inner: ExprId) -> bool {
        let is_told = |ty: &Ty| {
            matches!(ty, Ty::Adt(..) | Ty::Array(..) | Ty::Slice(_) | Ty::Param(_) | Ty::Opaque(_))
                || matches!(ty, Ty::Unknown | Ty::Var(_) | Ty::Tuple(_))
        };
        let (Ty::Pointer(to), Ty::Pointer(from) | Ty::Ref(true, from)) = (self.ty(id), self.ty(inner)) else {
            return false;
        };
        let mut origin = inner;
        while let ExprKind::Cast { value, .. } = &self.body().expr(origin).kind {
            origin = *value;
        }
        !is_told(to.peel()) && self.may_hold_filter(from) && !matches!(self.ty(origin), Ty::Ref(false, _))
    }
}
