//! Filters in a `Box`: a guard borrows what lies in there, `kf = *self.kf`, and the name that it gives leads to the filter itself.

use super::body::LoopBody;
use super::mentions::{Guarded, is_format_operand};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind};

impl Guarded {
    pub(super) fn is_box(&self) -> bool {
        is_box(&self.ty)
    }

    /// The stars that lead from a box, or from a reference to one, to the filter in it.
    pub(super) fn stars(&self) -> Option<&'static str> {
        let holds_it =
            |ty: &Ty| is_box(ty) && matches!(ty, Ty::External(_, args) if args.first() == Some(&self.filter));
        match &self.ty {
            _ if self.place.element.is_some() => None,
            ty if holds_it(ty) => Some("*"),
            Ty::Ref(true, inner) if holds_it(inner) => Some("**"),
            _ => None,
        }
    }

    /// Whether a guard borrows it out of its box.
    pub(super) fn is_unboxed(&self) -> bool {
        self.adaptation.is_none() && self.stars().is_some()
    }
}

fn is_box(ty: &Ty) -> bool {
    matches!(ty, Ty::External(path, _) if path == "std::boxed::Box")
}

/// Whether a method is called here that a box has for itself.
pub(super) fn is_for_box(of: &LoopBody<'_>, own: &Guarded, at: ExprId) -> bool {
    let own_methods = ["as_ref", "as_mut", "clone", "clone_from", "to_owned"];
    is_box(own.ty.peel())
        && matches!(of.parent(at).map(|parent| of.kind(parent)), Some(ExprKind::MethodCall { receiver, method, .. })
            if *receiver == at && own_methods.contains(&method.as_str()))
}

/// What stands before the name where a box stood that the guard has opened; `None` where the box itself is meant.
pub(super) fn prefix(of: &LoopBody<'_>, own: &Guarded, at: ExprId, parent: ExprId) -> Option<&'static str> {
    let is_behind_reference = !own.is_box();
    let beyond = of.parent(parent).map(|beyond| of.kind(beyond));
    match of.kind(parent) {
        ExprKind::MethodCall { receiver, .. } if *receiver == at => Some(""),
        ExprKind::Field { .. } | ExprKind::Index { .. } => Some(""),
        ExprKind::Macro(_) => is_format_operand(of, at).then_some(""),
        ExprKind::Deref(_) if !is_behind_reference => Some(""),
        // One star leads to the box, and to the filter where a field or method is asked for, or where it is lent on.
        ExprKind::Deref(_) => match beyond? {
            ExprKind::Deref(_) | ExprKind::Field { .. } | ExprKind::Index { .. } => Some(""),
            ExprKind::Reference { raw: false, .. } => Some(""),
            ExprKind::MethodCall { receiver, .. } if *receiver == parent => Some(""),
            _ => None,
        },
        ExprKind::Reference { raw: false, mutable, .. } => match is_behind_reference {
            true => (!mutable).then_some(""),
            false => Some("*"),
        },
        ExprKind::Call { .. } | ExprKind::MethodCall { .. } if is_behind_reference => Some(""),
        _ => None,
    }
}

/// The star that goes where two of them led through a reference to a box: `**kf`.
pub(super) fn needless_star(of: &LoopBody<'_>, own: &Guarded, at: ExprId) -> Option<Span> {
    let parent = of.parent(at).filter(|_| own.is_unboxed() && !own.is_box())?;
    let beyond = of.parent(parent)?;
    let is_star = |id: ExprId| matches!(of.kind(id), ExprKind::Deref(_));
    (is_star(parent) && is_star(beyond)).then(|| of.span(parent))
}
