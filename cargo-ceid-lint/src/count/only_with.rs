//! What a function writes only where it gives something back: `fn fix(&mut self) -> Option<f32>` notes when a fix came, and nothing
//! where none did.

use std::collections::BTreeSet;

use super::aliases::Aliases;
use super::given::{Given, note, place_of};
use super::summary::Summaries;
use crate::flow::{ControlFlowGraph, Effect, Head, NodeId, Place, Var};

/// The places among what a function writes that it leaves alone on all ways that give back `None` or `Err`.
pub(super) fn present(
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    summaries: &Summaries,
    writes: &BTreeSet<Given>,
) -> BTreeSet<Given> {
    let heads = || graph.nodes.iter().filter_map(|node| head_of(&node.effect));
    if writes.is_empty() || !heads().any(is_present) {
        return BTreeSet::new();
    }
    let mut without: BTreeSet<Given> = BTreeSet::new();
    for id in graph.node_ids() {
        let mut written = BTreeSet::new();
        match &graph.node(id).effect {
            Effect::Write(write) => note(graph, aliases, &write.place, &mut written),
            Effect::Call(site) => {
                let callees = site.targets.iter().filter_map(|target| summaries.get(*target));
                for place in callees.flat_map(|callee| &callee.writes).filter_map(|given| place_of(given, site)) {
                    note(graph, aliases, &place, &mut written);
                }
            }
            _ => continue,
        }
        if written.iter().any(|given| !without.contains(given)) && leads_to_nothing(graph, id) {
            without.extend(written);
        }
    }
    let is_part = |own: &Given, other: &Given| own.base == other.base && own.steps.starts_with(&other.steps);
    let is_without = |given: &Given| without.iter().any(|other| is_part(given, other) || is_part(other, given));
    writes.iter().filter(|given| !is_without(given)).cloned().collect()
}

fn head_of(effect: &Effect) -> Option<&Head> {
    match effect {
        Effect::Return(value) => value.head.as_ref(),
        Effect::Set(set) => set.head.as_ref(),
        _ => None,
    }
}

fn is_present(head: &Head) -> bool {
    head == "+"
}

/// Whether a way from a node may end with a result that is not known to hold something.
fn leads_to_nothing(graph: &ControlFlowGraph, from: NodeId) -> bool {
    let returned = |effect: &Effect| match effect {
        Effect::Return(value) => value.same_as,
        _ => None,
    };
    let results: BTreeSet<Var> = graph.nodes.iter().filter_map(|node| returned(&node.effect)).collect();
    let is_always_present = |var: Var| {
        let mut sets = graph.nodes.iter().filter_map(|node| match &node.effect {
            Effect::Set(set) if set.place == Place::var(var) => Some(set),
            _ => None,
        });
        graph.var(var).param.is_none() && sets.all(|set| set.head.as_ref().is_some_and(is_present))
    };
    let mut seen = BTreeSet::new();
    let mut open: Vec<(NodeId, bool)> = graph.node(from).next.iter().map(|next| (*next, false)).collect();
    while let Some((id, mut is_there)) = open.pop() {
        if !seen.insert((id, is_there)) {
            continue;
        }
        match &graph.node(id).effect {
            Effect::Return(value) => {
                let is_there = match (&value.head, value.same_as) {
                    (Some(head), _) => is_present(head),
                    (None, Some(var)) => is_there || is_always_present(var),
                    (None, None) => false,
                };
                if !is_there {
                    return true;
                }
            }
            Effect::Set(set) if results.iter().any(|var| set.place == Place::var(*var)) => {
                is_there = set.head.as_ref().is_some_and(is_present);
            }
            _ => {}
        }
        open.extend(graph.node(id).next.iter().map(|next| (*next, is_there)));
    }
    false
}
