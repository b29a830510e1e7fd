//! The heads that a function gives to what it was lent, where they are all known: `fn stop(&mut self) { self.started = None; }`. A
//! condition behind the call can then find nothing else than these, or what was there before where not all ways give one.

use std::collections::{BTreeMap, BTreeSet};

use super::aliases::Aliases;
use super::given::{Given, given, place_of};
use super::summary::Summaries;
use crate::flow::{ControlFlowGraph, Effect, Head, NodeId, Place};
use crate::index::Ty;

/// What a function gives to a state.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct GivenHeads {
    /// All heads that it gives it.
    pub(super) heads: BTreeSet<Head>,
    /// Whether each of its ways gives one.
    pub(super) surely: bool,
}

pub(super) fn find(graph: &ControlFlowGraph, aliases: &Aliases, summaries: &Summaries) -> BTreeMap<Given, GivenHeads> {
    let mut found: BTreeMap<Given, BTreeSet<Head>> = BTreeMap::new();
    let mut others: BTreeSet<Given> = BTreeSet::new();
    let known = |place: &Place| -> Vec<Given> {
        aliases.shared_roots(place).iter().filter_map(|root| given(graph, root)).collect()
    };
    for node in &graph.nodes {
        match &node.effect {
            Effect::Write(write) => match &write.head {
                Some(head) => known(&write.place).into_iter().for_each(|given| {
                    found.entry(given).or_default().insert(head.clone());
                }),
                None => others.extend(known(&write.place)),
            },
            Effect::Call(site) => {
                for summary in site.targets.iter().filter_map(|target| summaries.get(*target)) {
                    for written in &summary.writes {
                        let places = place_of(written, site).iter().flat_map(known).collect::<Vec<_>>();
                        match summary.given_heads.get(written) {
                            Some(own) => places.into_iter().for_each(|given| {
                                found.entry(given).or_default().extend(own.heads.iter().cloned());
                            }),
                            None => others.extend(places),
                        }
                    }
                }
            }
            Effect::Unknown { places, .. } => others.extend(places.iter().flat_map(known)),
            _ => {}
        }
    }
    // What is written as a part of something else, or together with it, has a head that is not told here.
    let overlap = |left: &Given, right: &Given| {
        left.base == right.base && left.steps.iter().zip(right.steps.iter()).all(|(left, right)| left == right)
    };
    let written: Vec<Given> = found.keys().chain(&others).cloned().collect();
    found.retain(|given, _| {
        !others.contains(given) && written.iter().all(|other| other == given || !overlap(given, other))
    });
    let with_certainty = |(given, heads): (Given, BTreeSet<Head>)| {
        let surely = is_given_on_all_ways(graph, aliases, summaries, &given);
        (given, GivenHeads { heads, surely })
    };
    found.into_iter().map(with_certainty).collect()
}

/// Whether no way leads through a function without giving a state one of its known heads.
fn is_given_on_all_ways(graph: &ControlFlowGraph, aliases: &Aliases, summaries: &Summaries, given: &Given) -> bool {
    // What a parameter holds by value is another one than the caller's.
    let is_lent = |root: &Place| root.base_var().is_none_or(|var| matches!(graph.var(var).ty, Ty::Ref(..)));
    let is_it = |place: &Place| {
        let roots = aliases.shared_roots(place);
        matches!(&roots[..], [root] if is_lent(root)
            && !root.stands_for_several()
            && super::given::given(graph, root).as_ref() == Some(given))
    };
    let gives = |id: NodeId| match &graph.node(id).effect {
        Effect::Write(write) => write.head.is_some() && is_it(&write.place),
        Effect::Call(site) => {
            let [target] = site.targets.as_slice() else { return false };
            let all = summaries.get(*target).into_iter().flat_map(|summary| &summary.given_heads);
            all.filter(|(_, own)| own.surely).filter_map(|(own, _)| place_of(own, site)).any(|place| is_it(&place))
        }
        _ => false,
    };
    let mut seen: BTreeSet<NodeId> = BTreeSet::new();
    let mut open = vec![NodeId(0)];
    while let Some(id) = open.pop() {
        if gives(id) || !seen.insert(id) {
            continue;
        }
        if matches!(graph.node(id).effect, Effect::Return(_)) {
            return false;
        }
        open.extend(&graph.node(id).next);
    }
    true
}
