//! Resets of filters that data chooses: `if let Some(voice) = voices.iter_mut().find(|voice| !voice.is_on) { voice.tone.reset(); … }`.
//! Nothing is certain of any one of them; that whoever chooses one resets it as well, is.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::aliases::Aliases;
use super::given::{Given, MAX_PLACES, given, place_of};
use super::instances::{holds_filter_at, place_ty};
use super::summary::Summaries;
use crate::flow::{ControlFlowGraph, Effect, IndexKey, Place, Transfer};
use crate::index::{Index, Ty};

/// The places of filters that a function resets where data chooses them.
pub(super) fn find(
    index: &Index,
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    summaries: &Summaries,
) -> BTreeSet<Given> {
    let mut found = BTreeSet::new();
    let mut add = |place: &Place| {
        let is_chosen = |root: &&Place| root.steps.iter().any(|step| matches!(step.key(), Some(IndexKey::Data(_))));
        found.extend(aliases.shared_roots(place).iter().filter(is_chosen).filter_map(|root| given(graph, root)));
    };
    for node in &graph.nodes {
        match &node.effect {
            Effect::Reset { place, full: true } => add(place),
            Effect::Write(write)
                if write.transfer != Transfer::Borrow && holds_filter_at(index, graph, &write.place) =>
            {
                add(&write.place);
            }
            Effect::Call(site) => {
                for callee in site.targets.iter().filter_map(|target| summaries.get(*target)) {
                    let ways = callee.all_outcomes().filter(|(_, ways)| !ways.is_empty());
                    let reset = ways.filter(|(_, ways)| ways.iter().all(|way| way.reset)).map(|(given, _)| given);
                    reset
                        .chain(&callee.chosen_resets)
                        .filter_map(|given| place_of(given, site))
                        .for_each(|place| add(&place));
                }
            }
            _ => {}
        }
    }
    if found.len() > MAX_PLACES { BTreeSet::new() } else { found }
}

/// The elements of an array that are updated together and reset one by one, if all of them are: each is an instance then.
pub(super) fn one_by_one(
    index: &Index,
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    places: &BTreeSet<Place>,
) -> Vec<Place> {
    let mut reset: BTreeSet<Place> = BTreeSet::new();
    for node in &graph.nodes {
        if let Effect::Reset { place, full: true } = &node.effect {
            reset.extend(aliases.roots(place));
        }
    }
    let has_all = |place: &Place| {
        let at = place.steps.iter().position(|step| matches!(step.key(), Some(IndexKey::Number(_))))?;
        let collection = place.up_to(at);
        let Some(Ty::Array(_, length)) = place_ty(index, graph, &collection) else { return None };
        let element = |number| {
            let mut element = place.clone();
            Arc::make_mut(&mut element.steps)[at] = place.steps[at].with_key(IndexKey::Number(number));
            element
        };
        Some((0..length.value?).all(|number| reset.contains(&element(number))))
    };
    let is_updated = |place: &Place| places.iter().any(|updated| updated.overlaps(place));
    reset.iter().filter(|place| is_updated(place) && has_all(place) == Some(true)).cloned().collect()
}
