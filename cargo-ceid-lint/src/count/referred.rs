//! Variables that refer to what refers to filters itself: `let slot = &mut self.slots[0]; *slot = Some(&mut lag);`

use crate::flow::{Assignment, ControlFlowGraph, Effect, NodeId, Place};
use crate::index::{Index, Ty};

/// The other names of a place of references, where it is reached by such a variable.
pub(super) fn led_to(index: &Index, graph: &ControlFlowGraph, place: &Place) -> Vec<Place> {
    let Some(var) = place.base_var() else { return Vec::new() };
    let Ty::Ref(true, inner) = &graph.var(var).ty else { return Vec::new() };
    // What a reference to a filter leads to is the filter itself.
    if place.steps.is_empty() && !index.refers_to_filters(inner) {
        return Vec::new();
    }
    let whole = Place::var(var);
    let given = graph.nodes.iter().filter_map(|node| match &node.effect {
        Effect::Set(set) if set.place == whole => set.from.as_ref(),
        _ => None,
    });
    let items = graph.loops.iter().flat_map(|info| &info.items);
    let lent = items.filter(|(item, _)| *item == var).map(|(_, source)| source);
    let mut all: Vec<Place> = given.chain(lent).map(|from| from.join(&place.steps)).collect();
    all.sort();
    all.dedup();
    all
}

/// Whether a node gives nothing but variables of the function another reference, by what refers to these:
/// `let slot = &mut now; *slot = &mut *other;`
pub(super) fn is_of_variables(index: &Index, graph: &ControlFlowGraph, node: NodeId, set: &Assignment) -> bool {
    let is_variable = |place: &Place| {
        let info = place.base_var().map(|var| graph.var(var));
        info.is_some_and(|info| info.param.is_none() && (place.steps.is_empty() || !matches!(info.ty, Ty::Ref(..))))
    };
    let led_to = led_to(index, graph, &set.place);
    graph.pointed.contains(&node) && !led_to.is_empty() && led_to.iter().all(is_variable)
}
