//! Filters that lie in what a recursive type has of itself: `node.next.next.filter`.

use super::analyse::FunctionFacts;
use super::bottom_up::too_many_ways;
use super::cycles::Instance;
use super::instances::{inner, place_ty};
use super::verdict::{Pair, Verdict};
use crate::flow::{ControlFlowGraph, Effect, Node, Place};
use crate::index::{Index, Ty};

/// Whether nothing is known of a filter because a recursion comes to it, and the same is said of one that lies less deep.
pub(super) fn is_told_by_outer(index: &Index, facts: &FunctionFacts<'_>, instance: &Instance, pair: &Pair) -> bool {
    let place = &instance.place;
    let is_less_deep = |other: &Instance| {
        other.law == instance.law
            && other.place.base == place.base
            && other.place.steps.len() < place.steps.len()
            && other.place.steps.last() == place.steps.last()
    };
    let is_around = |other: &Instance| {
        other.place.base == place.base
            && other.place.steps.len() < place.steps.len()
            && place.steps.starts_with(&other.place.steps)
            && only_law_reaches(facts, &other.place, place)
    };
    pair.verdict == Verdict::Unproved
        && pair.cause.as_ref().is_some_and(|cause| *cause == too_many_ways(true).to_string())
        && (has_owner_twice(index, facts.graph, place) && facts.updated.iter().any(is_less_deep)
            || facts.updated.iter().any(is_around))
}

/// Whether nothing but the law of a composite, which is the cycle of what lies inside of it, has to do with a part of it.
fn only_law_reaches(facts: &FunctionFacts<'_>, composite: &Place, part: &Place) -> bool {
    let roots = |place: &Place| facts.aliases.shared_roots(place).to_vec();
    let reaches = |place: &Place| roots(place).iter().any(|root| root.overlaps(part));
    let is_it = |place: &Place| roots(place) == [composite.clone()];
    let is_law = |node: &Node| match &node.effect {
        Effect::Call(site) => {
            let own = site.law_of.and_then(|number| site.args.get(number)?.place.as_ref());
            let mut lent = site.args.iter().filter(|arg| !arg.is_shared).filter_map(|arg| arg.place.as_ref());
            own.is_some_and(is_it) || !lent.any(reaches)
        }
        Effect::Update(update) => is_it(&update.place) || !reaches(&update.place),
        Effect::Unknown { places, .. } => !places.iter().any(reaches),
        Effect::Advance(advance) => !reaches(&advance.before),
        _ => true,
    };
    facts.graph.nodes.iter().all(is_law)
}

/// Whether the way to a place leads twice through the same type.
pub(super) fn has_owner_twice(index: &Index, graph: &ControlFlowGraph, place: &Place) -> bool {
    let mut owners = Vec::new();
    (0..place.steps.len()).any(|count| {
        let owner = place.up_to(count);
        match place_ty(index, graph, &owner).map(|ty| inner(&ty)) {
            Some(Ty::Adt(id, _)) if owners.contains(&id) => true,
            Some(Ty::Adt(id, _)) => {
                owners.push(id);
                false
            }
            _ => false,
        }
    })
}
