//! States that a function takes and gives back: they are not those that it is called with the next time.

use super::search::Search;
use crate::flow::{ControlFlowGraph, Place, Projection};
use crate::index::{Index, Ty};

/// Whether the function was given the instance itself, and no reference to it: a state that it takes and gives back is not the one
/// that it is called with the next time.
pub(super) fn is_given_away(search: &Search<'_>, graph: &ControlFlowGraph, instance: &Place) -> bool {
    let Some(info) = instance.base_var().map(|var| graph.var(var)).filter(|info| info.param.is_some()) else {
        return false;
    };
    let index = search.program.index;
    if gives_back(index, graph, &info.ty) {
        return owns(index, &info.ty, &instance.steps);
    }
    // What a field leads to may be someone else's, and what the function hands to a thread or does in rounds goes on.
    let is_owned =
        |ty: &Ty| matches!(ty, Ty::Adt(..)) && index.filter_spec(ty).is_some() && index.returned_spec(ty).is_none();
    instance.steps.is_empty() && is_owned(&info.ty) && graph.loops.is_empty()
}

/// Whether a function gives back a value of the type, as one does that takes a value to complete it: `fn warmed_up(mut self) -> Self`.
fn gives_back(index: &Index, graph: &ControlFlowGraph, ty: &Ty) -> bool {
    let output = &index.function(graph.function).function.output;
    let output = index.lower(output, &index.scope_of(graph.function));
    let is_it = |given: &Ty| matches!((given, ty), (Ty::Adt(given, _), Ty::Adt(own, _)) if given == own);
    match &output {
        Ty::External(_, parts) | Ty::Tuple(parts) => parts.iter().any(is_it),
        given => is_it(given),
    }
}

/// Whether a part of a value is its own: no reference or handle leads there.
fn owns(index: &Index, ty: &Ty, steps: &[Projection]) -> bool {
    let mut ty = ty.clone();
    for step in steps {
        let next = match step {
            Projection::Field(name) => index.field_ty(&ty, None, name),
            Projection::Index(_) => match ty {
                Ty::Array(inner, _) => Some(*inner),
                _ => None,
            },
            Projection::Channel(_) => None,
        };
        match next {
            Some(next) => ty = next,
            None => return false,
        }
    }
    matches!(ty, Ty::Adt(..))
}
