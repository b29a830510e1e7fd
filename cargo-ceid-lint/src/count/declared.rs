//! The types of places as they are declared.

use super::instances::{inner, place_ty};
use crate::flow::{Base, ControlFlowGraph, Place, Projection};
use crate::index::{Index, Ty};
use crate::types::is_transparent;

/// The type of a place as it is declared, with its references, pointers, options and locks; `None` for an element that is looked up.
pub(super) fn declared_ty(index: &Index, graph: &ControlFlowGraph, place: &Place) -> Option<Ty> {
    let Some((last, steps)) = place.steps.split_last() else { return Some(base_ty(index, graph, place.base)) };
    let owner = place_ty(index, graph, &Place { base: place.base, steps: steps.into() })?;
    match (last, inner(&owner)) {
        (Projection::Field(name), Ty::Tuple(parts)) => parts.get(name.parse::<usize>().ok()?).cloned(),
        (Projection::Field(name), owner) => index.field_ty(&owner, None, name),
        (Projection::Index(_), owner) => owner.element().cloned(),
        (Projection::Channel(_), _) => None,
    }
}

/// What a condition on a place may ask for: the options and results around what is there, outer ones first, and the type of that.
/// Places of one instance may differ in it: `fn phase(&mut self) -> Option<&Phase>` lends the phase, and is asked for `Some`.
pub(super) fn state_ty(index: &Index, graph: &ControlFlowGraph, place: &Place) -> Option<(Vec<String>, Ty)> {
    let ty = declared_ty(index, graph, place)?;
    let mut around = Vec::new();
    let mut at = ty.peel();
    while let Ty::External(path, args) = at
        && let Some(name) = path.rsplit("::").next().filter(|name| is_transparent(name))
        && let Some(inside) = args.first()
    {
        around.extend(matches!(name, "Option" | "Result" | "Poll" | "LockResult").then(|| name.to_owned()));
        at = inside.peel();
    }
    Some((around, inner(&ty)))
}

/// The type of a variable or static.
pub(super) fn base_ty(index: &Index, graph: &ControlFlowGraph, base: Base) -> Ty {
    match base {
        Base::Var(var) => graph.var(var).ty.clone(),
        Base::Static(id) => {
            let value = index.value(id);
            index.lower(&value.item.ty, &index.scope(value.module, value.owner, None))
        }
    }
}
