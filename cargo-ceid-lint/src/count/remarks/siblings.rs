//! Filters that nothing updates beside one that a function updates twice: perhaps its line was pasted. A function that is only
//! presumed to be a cycle owes them nothing, so that they have no pair of their own.

use crate::count::analyse::{Context, FunctionFacts};
use crate::count::fields::{Fields, field_key};
use crate::count::instances::leaves;
use crate::count::verdict::{Pair, Verdict};
use crate::flow::Place;

/// Notes at each filter that is updated twice its siblings of the same type that nothing updates anywhere.
pub(super) fn add(context: &Context<'_>, facts: &FunctionFacts<'_>, pairs: &mut [Pair]) {
    let graph = facts.graph;
    let index = context.program.index;
    for pair in pairs.iter_mut().filter(|pair| pair.verdict == Verdict::Repeated) {
        let own = facts.updated.iter().find(|instance| graph.place_name(index, &instance.place) == pair.name);
        let Some(var) = own.and_then(|instance| instance.place.base_var()) else { continue };
        for leaf in leaves(index, &graph.var(var).ty).iter().filter(|leaf| !leaf.is_uncertain) {
            let place = Place::var(var).join(&leaf.steps);
            let is_updated = facts.updated.iter().any(|instance| instance.place.overlaps(&place));
            let is_touched = |fields: &Fields| !fields.laws(index, graph, &place).is_empty();
            let is_elsewhere =
                field_key(index, graph, &place).is_none() || is_touched(context.fields) || is_touched(context.anywhere);
            if index.type_name(&leaf.ty) == pair.filter_type && !is_updated && !is_elsewhere {
                pair.left_out.push(graph.place_name(index, &place));
            }
        }
    }
}
