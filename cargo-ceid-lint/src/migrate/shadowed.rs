//! Methods that a reference has for itself: called on the name that a guard gives, they would mean that, and not the filter.

use super::body::LoopBody;
use crate::index::{FunctionId, Index, Owner, TraitName, Ty};
use crate::syntax::tree::{ExprId, ExprKind, Receiver};
use crate::types::Callee;

/// Whether a method is called here that the reference behind the guard has for itself.
pub(super) fn is_shadowed(of: &LoopBody<'_>, at: ExprId) -> bool {
    let Some(parent) = of.parent(at) else { return false };
    matches!(of.kind(parent), ExprKind::MethodCall { receiver, .. } if *receiver == at) && is_for_references(of, parent)
}

/// Whether a reference has the method that is called for itself: one of the standard library, or of a trait that the code gives to all
/// types.
pub(super) fn is_for_references(of: &LoopBody<'_>, call: ExprId) -> bool {
    let ExprKind::MethodCall { method, .. } = of.kind(call) else { return false };
    is_by_value(method)
        || matches!(
            method.as_str(),
            "eq" | "ne" | "cmp" | "partial_cmp" | "lt" | "le" | "gt" | "ge" | "borrow" | "borrow_mut" | "type_id"
        )
        || targets(of, call).iter().any(|method| is_of_all_types(of.program.index, *method))
}

/// Those of them that take the value.
pub(super) fn is_by_value(method: &str) -> bool {
    matches!(method, "into" | "try_into" | "max" | "min" | "clamp")
}

/// Whether a method of a reference is called here that takes what that leads to, as one that takes `&mut self` does.
pub(super) fn is_of_pointee(of: &LoopBody<'_>, at: ExprId, ty: &Ty) -> bool {
    let Some(call) = of.parent(at) else { return false };
    let takes_it =
        |method: &FunctionId| of.program.index.function(*method).function.receiver == Some(Receiver::Exclusive);
    let methods = targets(of, call);
    matches!(ty, Ty::Ref(true, inner) if matches!(**inner, Ty::Adt(..)))
        && !methods.is_empty()
        && methods.iter().all(takes_it)
}

fn targets<'a>(of: &LoopBody<'a>, call: ExprId) -> &'a [FunctionId] {
    match of.typed.callees.get(&call) {
        Some(Callee::Resolved(callee)) => &callee.targets,
        _ => &[],
    }
}

/// Whether the trait of a method is one of all types, or of references as well.
fn is_of_all_types(index: &Index, method: FunctionId) -> bool {
    let of_trait = match index.function(method).owner {
        Owner::Trait(id) => Some(TraitName::Local(id)),
        Owner::Impl(id) => index.impl_def(id).implements.clone(),
        Owner::Module => None,
    };
    of_trait.is_some_and(|of_trait| may_have(index, &of_trait, &mut Vec::new()))
}

/// Whether a reference to a filter, or what lends one, may have a trait.
fn may_have<'i>(index: &'i Index, of_trait: &'i TraitName, asked: &mut Vec<&'i TraitName>) -> bool {
    asked.push(of_trait);
    let impls = index.impls.iter().filter(|own| own.implements.as_ref() == Some(of_trait));
    let mut types = impls.map(|own| &own.self_ty);
    types.any(|ty| match ty {
        Ty::Ref(..) => true,
        Ty::Param(param) => param.bounds.iter().all(|bound| match &bound.name {
            TraitName::External(path) => {
                !matches!(&**path, "std::marker::Copy" | "std::clone::Clone" | "std::default::Default")
            }
            // A trait that asks for itself gives nothing.
            of @ TraitName::Local(_) => !asked.contains(&of) && may_have(index, of, asked),
        }),
        _ => false,
    })
}
