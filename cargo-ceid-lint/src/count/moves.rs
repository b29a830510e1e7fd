//! Where values go that are moved, whatever the way: from place to place, and through functions that give back what they take.

use std::collections::BTreeSet;

use super::chosen_returns::Borrow;
use super::given::is_put_in_place;
use super::instances::{leaves_and_payloads, place_ty};
use super::summary::Summaries;
use crate::flow::{Assignment, ControlFlowGraph, Effect, IndexKey, LoopId, Place, Relation, Transfer};
use crate::index::{Index, Ty};

/// How many places a value is followed through, and how many steps each of these may have.
const MAX_PLACES: usize = 64;
const MAX_STEPS: usize = 16;

/// The elements of the arrays that are copied as a whole: `for mut filter in self.bank`.
pub(super) fn copied_elements(index: &Index, graph: &ControlFlowGraph) -> impl Iterator<Item = Place> {
    let copied = graph.nodes.iter().filter_map(|node| match &node.effect {
        Effect::Set(set) if set.transfer == Transfer::Copy => set.from.as_ref(),
        _ => None,
    });
    let is_array = |place: &&Place| matches!(place_ty(index, graph, place), Some(Ty::Array(..)));
    copied.filter(is_array).map(|place| place.clone().element(IndexKey::Each))
}

/// The places to which what is in one may be moved, and that place; with those that it changes with or without.
pub(super) fn reached(
    graph: &ControlFlowGraph,
    summaries: &Summaries,
    place: &Place,
    with_swaps: bool,
) -> BTreeSet<Place> {
    let edges = graph.nodes.iter().flat_map(|node| match &node.effect {
        Effect::Set(set) if !with_swaps && is_put_in_place(graph, set) => Vec::new(),
        Effect::Set(set) | Effect::Write(set) if set.transfer == Transfer::Copy => Vec::new(),
        effect => edges_of(summaries, effect),
    });
    followed(place, &edges.collect::<Vec<_>>())
}

/// The places in which what is in one, or a copy or a clone of it, may come to lie within a loop, and that place.
pub(super) fn copied_to(
    graph: &ControlFlowGraph,
    summaries: &Summaries,
    place: &Place,
    within: Option<LoopId>,
) -> BTreeSet<Place> {
    let is_within = |at: Option<LoopId>| within.is_none_or(|id| graph.is_within(at, id));
    let nodes = graph.nodes.iter().filter(|node| is_within(node.in_loop));
    let copies = nodes.clone().filter_map(|node| match &node.effect {
        Effect::Call(site) => Some(site),
        _ => None,
    });
    let copies = copies.flat_map(|site| {
        let targets = site.targets.iter().filter_map(|target| summaries.get(*target));
        targets.flat_map(|target| &target.copies).filter_map(|copy| {
            let from = site.args.get(copy.param)?.place.as_ref()?;
            Some((from.join(&copy.steps), Place::var(site.result).join(&copy.part)))
        })
    });
    let items = graph.loops.iter().flat_map(|info| &info.items).map(|(item, from)| (from.clone(), Place::var(*item)));
    let edges = nodes.flat_map(|node| edges_of(summaries, &node.effect)).chain(copies).chain(items);
    followed(place, &edges.collect::<Vec<_>>())
}

/// From where to where something goes at a node.
fn edges_of(summaries: &Summaries, effect: &Effect) -> Vec<(Place, Place)> {
    match effect {
        Effect::Set(set) | Effect::Write(set) => {
            set.from.iter().map(|from| (from.clone(), set.place.clone())).collect()
        }
        Effect::Call(site) => {
            let result = Place::var(site.result);
            summaries.borrows(site).map(|(part, from)| (from, result.join(part))).collect()
        }
        _ => Vec::new(),
    }
}

fn followed(place: &Place, edges: &[(Place, Place)]) -> BTreeSet<Place> {
    let mut found = BTreeSet::from([place.clone()]);
    let mut open = vec![place.clone()];
    while let Some(name) = open.pop() {
        for (from, to) in edges {
            if let Relation::Holds(rest) = from.relate(&name, &|_| None) {
                let to = to.join(&rest);
                if to.steps.len() <= MAX_STEPS && found.len() < MAX_PLACES && found.insert(to.clone()) {
                    open.push(to);
                }
            }
        }
    }
    found
}

/// The filters in what a function takes by value that may lie in what it gives back: `fn next(self) -> State`. Whether it has a copy,
/// its callers know.
pub(super) fn given_back(index: &Index, graph: &ControlFlowGraph, summaries: &Summaries) -> BTreeSet<Borrow> {
    let is_taken = |ty: &Ty| matches!(ty, Ty::Adt(..) | Ty::External(..) | Ty::Tuple(_));
    in_result(index, graph, is_taken, |filter| reached(graph, summaries, filter, true))
}

/// The filters in what a function takes or is lent of which copies or clones may lie in what it gives back:
/// `fn next_lap(&self) -> Self { Self { pid: self.pid.clone(), laps: self.laps + 1 } }`.
pub(super) fn copied_back(index: &Index, graph: &ControlFlowGraph, summaries: &Summaries) -> BTreeSet<Borrow> {
    if !graph.nodes.iter().any(|node| matches!(&node.effect, Effect::Return(value) if value.place.is_some())) {
        return BTreeSet::new();
    }
    in_result(index, graph, |_| true, |filter| copied_to(graph, summaries, filter, None))
}

/// The filters in parameters of some types that may lie in the result, where `places` says where each may lie.
fn in_result(
    index: &Index,
    graph: &ControlFlowGraph,
    takes: impl Fn(&Ty) -> bool,
    places: impl Fn(&Place) -> BTreeSet<Place>,
) -> BTreeSet<Borrow> {
    let mut found = BTreeSet::new();
    for (param, var) in graph.params.iter().enumerate() {
        let ty = &graph.var(*var).ty;
        if !takes(ty) {
            continue;
        }
        for leaf in leaves_and_payloads(index, ty.peel()) {
            let names = places(&Place::var(*var).join(&leaf.steps));
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
