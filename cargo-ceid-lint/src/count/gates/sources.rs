//! What a value is computed from, by any number of steps.

use std::collections::{BTreeMap, BTreeSet};

use crate::flow::{Computed, ControlFlowGraph, Effect, NodeId, Place, Var, VarInfo, reads_shared_number};
use crate::index::Ty;

/// How many places are followed; beyond that nothing more is found.
const MAX_PLACES: usize = 256;

/// The places and calls behind a value.
#[derive(Clone, Debug, Default)]
pub(super) struct Sources {
    pub(super) places: Vec<Place>,
    pub(super) calls: BTreeSet<String>,
}

impl Sources {
    pub(super) fn has_var(&self, var: Var) -> bool {
        self.places.iter().any(|place| place.base_var() == Some(var))
    }
}

/// The assignments of a function, by the variable or static that they change.
#[derive(Debug)]
pub(super) struct Assignments<'a> {
    graph: &'a ControlFlowGraph,
    of: BTreeMap<crate::flow::Base, Vec<NodeId>>,
}

impl<'a> Assignments<'a> {
    pub(super) fn new(graph: &'a ControlFlowGraph) -> Self {
        let mut of: BTreeMap<crate::flow::Base, Vec<NodeId>> = BTreeMap::new();
        for id in graph.node_ids() {
            if let Effect::Set(set) | Effect::Write(set) = &graph.node(id).effect {
                of.entry(set.place.base).or_default().push(id);
            }
        }
        Self { graph, of }
    }

    /// The nodes that assign to places of a variable or static.
    pub(super) fn of(&self, place: &Place) -> &[NodeId] {
        self.of.get(&place.base).map(Vec::as_slice).unwrap_or_default()
    }

    /// Follows values back to what they are computed from.
    pub(super) fn behind(&self, start: &Computed) -> Sources {
        let graph = self.graph;
        let mut found = Sources::default();
        found.calls.extend(start.calls.iter().cloned());
        for place in &start.places {
            add(&mut found.places, place);
        }
        let mut at = 0;
        while at < found.places.len() && found.places.len() < MAX_PLACES {
            let place = found.places[at].clone();
            at += 1;
            let is_lent =
                |info: &VarInfo| info.param.is_some() || info.name == "self" || matches!(info.ty, Ty::Ref(..));
            // What is read is a part of it: `self.board.tacho.read()` reads nothing else of the board.
            let has_part = |other: &Place| {
                other.base == place.base
                    && other.steps.len() > place.steps.len()
                    && other.steps.starts_with(&place.steps)
            };
            let is_whole = place.steps.is_empty() || found.places.iter().any(has_part);
            let is_owner = is_whole && place.base_var().is_some_and(|var| is_lent(graph.var(var)));
            if let Some(var) = place.base_var()
                && let Some(computed) = graph.computed.get(&var)
            {
                found.calls.extend(computed.calls.iter().cloned());
                for from in &computed.places {
                    add(&mut found.places, from);
                }
            }
            for id in self.of(&place) {
                let (Effect::Set(set) | Effect::Write(set)) = &graph.node(*id).effect else { continue };
                if set.place != place && (is_owner || !set.place.overlaps(&place)) {
                    continue;
                }
                for from in set.from.iter().cloned().chain(set.same_as.map(Place::var)) {
                    add(&mut found.places, &from);
                }
                if let Some(change) = graph.changes.get(id) {
                    found.calls.extend(change.computed.calls.iter().cloned());
                    for from in &change.computed.places {
                        add(&mut found.places, from);
                    }
                }
            }
        }
        found
    }
}

fn add(places: &mut Vec<Place>, place: &Place) {
    if !places.contains(place) {
        places.push(place.clone());
    }
}

/// Whether a name contains one of these parts, in whatever case.
pub(super) fn contains_any(name: &str, parts: &[&str]) -> bool {
    let name = name.to_lowercase();
    parts.iter().any(|part| name.contains(part))
}

/// What reads a number that is shared with others, or counts it.
pub(super) fn counts_shared(name: &str) -> bool {
    reads_shared_number(name) || matches!(name, "fetch_add" | "fetch_sub")
}

/// Methods that only reckon.
pub(super) fn is_arithmetic(name: &str) -> bool {
    matches!(name, "is_multiple_of" | "rem_euclid" | "abs" | "min" | "max" | "unwrap" | "into")
        || name.starts_with("wrapping_")
}
