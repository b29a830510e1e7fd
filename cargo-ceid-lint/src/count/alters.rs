//! What a function writes, but for what laws write of their own filters: a helper that only runs laws alters none.

use std::collections::BTreeSet;

use super::aliases::Aliases;
use super::given::{Given, bound, note, place_of};
use super::summary::Summaries;
use crate::flow::{ControlFlowGraph, Effect};

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
