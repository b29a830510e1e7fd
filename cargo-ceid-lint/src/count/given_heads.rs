//! The heads that a function gives to what it was lent, where they are all known: `fn stop(&mut self) { self.started = None; }`. A
//! condition behind the call can then find nothing else than these, or what was there before.

use std::collections::{BTreeMap, BTreeSet};

use super::aliases::Aliases;
use super::given::{Given, given, place_of};
use super::summary::Summaries;
use crate::flow::{ControlFlowGraph, Effect, Head, Place};

pub(super) fn find(
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    summaries: &Summaries,
) -> BTreeMap<Given, BTreeSet<Head>> {
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
                            Some(heads) => places.into_iter().for_each(|given| {
                                found.entry(given).or_default().extend(heads.iter().cloned());
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
        left.base == right.base && left.steps.iter().zip(&right.steps).all(|(left, right)| left == right)
    };
    let written: Vec<Given> = found.keys().chain(&others).cloned().collect();
    found.retain(|given, _| {
        !others.contains(given) && written.iter().all(|other| other == given || !overlap(given, other))
    });
    found
}
