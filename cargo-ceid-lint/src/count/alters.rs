//! What a function writes, but for what laws write of their own filters: a helper that only runs laws alters none.

use std::collections::BTreeSet;

use super::aliases::Aliases;
use super::given::{Given, bound, note, place_of};
use super::instances::place_ty;
use super::summary::Summaries;
use crate::flow::{ControlFlowGraph, Effect, NodeId, Place, Update};
use crate::index::{Index, Ty};

pub(super) fn find(graph: &ControlFlowGraph, aliases: &Aliases, summaries: &Summaries) -> BTreeSet<Given> {
    let mut found = BTreeSet::new();
    for node in &graph.nodes {
        match &node.effect {
            Effect::Write(write) => note(graph, aliases, &write.place, &mut found),
            Effect::Call(site) => {
                let callees = site.targets.iter().filter_map(|target| summaries.get(*target));
                for place in callees.flat_map(|callee| &callee.alters).filter_map(|given| place_of(given, site)) {
                    note(graph, aliases, &place, &mut found);
                }
            }
            _ => {}
        }
    }
    bound(&mut found);
    found
}

/// What an update or a reset writes of a filter that is nothing but a number, as the state of a function is: that number.
pub(super) fn number_of<'g>(index: &Index, graph: &ControlFlowGraph, effect: &'g Effect) -> Option<&'g Place> {
    let (Effect::Update(Update { place, .. }) | Effect::Reset { place, .. }) = effect else { return None };
    let ty = place_ty(index, graph, place)?;
    matches!(ty.peel(), Ty::Float | Ty::Int | Ty::Bool).then_some(place)
}

/// Takes note of such a number.
pub(super) fn note_number(
    index: &Index,
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    at: NodeId,
    writes: &mut BTreeSet<Given>,
) {
    if let Some(number) = number_of(index, graph, &graph.node(at).effect) {
        note(graph, aliases, number, writes);
    }
}
