//! Where values go that are moved, whatever the way: from place to place, and through functions that give back what they take.

use std::collections::BTreeSet;

use super::chosen_returns::Borrow;
use super::given::is_put_in_place;
use super::instances::leaves_and_payloads;
use super::summary::Summaries;
use crate::flow::{Assignment, ControlFlowGraph, Effect, LoopId, Place, Relation, Transfer};
use crate::index::{Index, Ty};

/// How many places a value is followed through, and how many steps each of these may have.
const MAX_PLACES: usize = 64;
const MAX_STEPS: usize = 16;

/// The places to which what is in one may be moved, and that place; with those that it changes with or without.
pub(super) fn reached(
    graph: &ControlFlowGraph,
    summaries: &Summaries,
    place: &Place,
    with_swaps: bool,
) -> BTreeSet<Place> {
    let mut found = BTreeSet::from([place.clone()]);
    let mut open = vec![place.clone()];
    while let Some(name) = open.pop() {
        let mut add = |from: &Place, to: &Place| {
            if let Relation::Holds(rest) = from.relate(&name, &|_| None) {
                let to = to.join(&rest);
                if to.steps.len() <= MAX_STEPS && found.len() < MAX_PLACES && found.insert(to.clone()) {
                    open.push(to);
                }
            }
        };
        for node in &graph.nodes {
            match &node.effect {
                Effect::Set(set) if !with_swaps && is_put_in_place(graph, set) => {}
                Effect::Set(set) | Effect::Write(set) if set.transfer != Transfer::Copy => {
                    if let Some(from) = &set.from {
                        add(from, &set.place);
                    }
                }
                Effect::Call(site) => {
                    let result = Place::var(site.result);
                    for (part, from) in summaries.borrows(site) {
                        add(&from, &result.join(part));
                    }
                }
                _ => {}
            }
        }
    }
    found
}

/// The filters in what a function takes by value that may lie in what it gives back: `fn next(self) -> State`. Whether it has a copy,
/// its callers know.
pub(super) fn given_back(index: &Index, graph: &ControlFlowGraph, summaries: &Summaries) -> BTreeSet<Borrow> {
    let mut found = BTreeSet::new();
    for (param, var) in graph.params.iter().enumerate() {
        let ty = &graph.var(*var).ty;
        if !matches!(ty, Ty::Adt(..) | Ty::External(..) | Ty::Tuple(_)) {
            continue;
        }
        for leaf in leaves_and_payloads(index, ty) {
            let names = reached(graph, summaries, &Place::var(*var).join(&leaf.steps), true);
            let returned = graph.nodes.iter().filter_map(|node| match &node.effect {
                Effect::Return(value) => value.place.as_ref(),
                _ => None,
            });
            let parts = returned.flat_map(|place| {
                names.iter().filter_map(|name| match place.relate(name, &|_| None) {
                    Relation::Holds(part) => Some(part),
                    _ => None,
                })
            });
            found.extend(parts.map(|part| Borrow { part, param, steps: leaf.steps.clone() }));
        }
    }
    found
}

/// Whether a variable has a value of its own before it is given another one in a loop: `(a, b) = (b, a)`.
pub(super) fn is_given_another(graph: &ControlFlowGraph, set: &Assignment, at: Option<LoopId>) -> bool {
    let Some(info) = set.place.base_var().map(|var| graph.var(var)) else { return false };
    set.transfer == Transfer::Move
        && set.place.steps.is_empty()
        && !info.name.is_empty()
        && !matches!(info.ty, Ty::Ref(..))
        && info.in_loop != at
        && info.in_loop.is_none_or(|declared| graph.is_within(at, declared))
}
