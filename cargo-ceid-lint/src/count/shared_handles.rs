//! Handles whose clones share one instance: `Rc`, `Arc`, and what is made of them.

use std::collections::{BTreeMap, BTreeSet};

use super::summary::Summaries;
use crate::flow::{ControlFlowGraph, Effect, Place, Var};
use crate::index::Index;

/// The variables with a handle that goes to several places, so that all of these have the same instance, and those with its clones.
pub(super) fn shared_handles(index: &Index, graph: &ControlFlowGraph, summaries: &Summaries) -> BTreeSet<Var> {
    let handles: Vec<bool> = graph.vars.iter().map(|info| index.is_handle(&info.ty)).collect();
    let handle = |place: &Place| place.base_var().filter(|var| place.steps.is_empty() && handles[var.0 as usize]);
    let mut given: BTreeMap<Var, BTreeSet<Place>> = BTreeMap::new();
    for node in &graph.nodes {
        match &node.effect {
            Effect::Set(set) | Effect::Write(set) => {
                if let Some(var) = set.from.as_ref().and_then(handle) {
                    given.entry(var).or_default().insert(set.place.clone());
                }
            }
            Effect::Call(site) => {
                for (part, from, _) in summaries.gives(site) {
                    if let Some(var) = handle(&from) {
                        given.entry(var).or_default().insert(Place::var(site.result).join(part));
                    }
                }
            }
            _ => {}
        }
    }
    let mut shared = BTreeSet::new();
    let mut open: Vec<Var> = given.iter().filter(|(_, to)| to.len() > 1).map(|(var, _)| *var).collect();
    while let Some(var) = open.pop() {
        if shared.insert(var) {
            open.extend(given.get(&var).into_iter().flatten().filter_map(handle));
        }
    }
    shared
}
