//! What a function writes only where it gives something back: `fn fix(&mut self) -> Option<f32>` notes when a fix came, and nothing
//! where none did.

use std::collections::BTreeSet;

use super::aliases::Aliases;
use super::given::{Given, note};
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
    let leads_to_nothing = leading_to_nothing(graph);
    let mut without: BTreeSet<Given> = BTreeSet::new();
    for id in graph.node_ids().filter(|id| leads_to_nothing[id.0 as usize]) {
        let mut written = BTreeSet::new();
        match &graph.node(id).effect {
            Effect::Write(write) => note(graph, aliases, &write.place, &mut written),
            Effect::Call(site) => {
                for place in summaries.places(site, |callee| &callee.writes) {
                    note(graph, aliases, &place, &mut written);
                }
            }
            _ => continue,
        }
        without.extend(written);
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

/// Of each node, whether a way behind it may end with a result that is not known to hold something.
fn leading_to_nothing(graph: &ControlFlowGraph) -> Vec<bool> {
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
    let always: BTreeSet<Var> = results.iter().copied().filter(|var| is_always_present(*var)).collect();
    // Each node stands here twice: where the result is not known to hold something before it, and where it is.
    let number = |id: NodeId, is_there: bool| id.0 as usize * 2 + usize::from(is_there);
    let mut before: Vec<Vec<usize>> = vec![Vec::new(); graph.nodes.len() * 2];
    let mut leads = vec![false; before.len()];
    let mut open = Vec::new();
    for (id, is_there) in graph.node_ids().flat_map(|id| [(id, false), (id, true)]) {
        let own = number(id, is_there);
        let mut after = is_there;
        match &graph.node(id).effect {
            Effect::Return(value) => {
                let holds = match (&value.head, value.same_as) {
                    (Some(head), _) => is_present(head),
                    (None, Some(var)) => is_there || always.contains(&var),
                    (None, None) => false,
                };
                if !holds {
                    leads[own] = true;
                    open.push(own);
                }
            }
            Effect::Set(set) if results.iter().any(|var| set.place == Place::var(*var)) => {
                after = set.head.as_ref().is_some_and(is_present);
            }
            _ => {}
        }
        for next in &graph.node(id).next {
            before[number(*next, after)].push(own);
        }
    }
    while let Some(at) = open.pop() {
        for from in std::mem::take(&mut before[at]) {
            if !std::mem::replace(&mut leads[from], true) {
                open.push(from);
            }
        }
    }
    let behind = |id: NodeId| graph.node(id).next.iter().any(|next| leads[number(*next, false)]);
    graph.node_ids().map(behind).collect()
}
