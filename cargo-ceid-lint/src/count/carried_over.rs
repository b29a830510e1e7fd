//! State that is carried over by hand: an owner that gets all its values anew, and one filter of them from before, resets the others
//! only. `let pid = s.pid; s = S::new(); s.pid = pid;`

use std::collections::{BTreeMap, BTreeSet};

use super::aliases::Aliases;
use super::given::{Given, given, instance_of};
use super::instances::{leaves_and_payloads, place_ty};
use super::moves;
use super::summary::Summaries;
use crate::flow::{Assignment, ControlFlowGraph, Effect, LoopId, Place, Relation};
use crate::index::Index;

/// The places in which a filter or a copy of it may lie within a loop, whatever the way; none if something else may lie there as well,
/// or it may have been reset there.
pub(super) fn copies(
    graph: &ControlFlowGraph,
    summaries: &Summaries,
    filter: &Place,
    within: Option<LoopId>,
) -> BTreeSet<Place> {
    let found = moves::copied_to(graph, summaries, filter, within);
    let is_copy = |place: &Place| found.iter().any(|copy| copy != filter && copy.lies_at(place));
    let is_known = |from: &Place| found.iter().any(|copy| from.overlaps(copy));
    // Of a literal the parts are given one by one.
    let is_literal = |set: &Assignment| set.head.is_some() && !found.contains(&set.place);
    let is_made_of_others = graph.nodes.iter().any(|node| match &node.effect {
        Effect::Reset { place, .. } => is_copy(place),
        Effect::Set(set) | Effect::Write(set) => {
            is_copy(&set.place) && !set.is_of_part() && !is_literal(set) && !set.from.as_ref().is_some_and(is_known)
        }
        Effect::Call(site) => {
            let lent = site.args.iter().filter(|arg| !arg.is_shared).filter_map(|arg| arg.place.as_ref());
            let mut lent = lent.filter(|place| is_copy(place) || filter.lies_at(place)).peekable();
            let known = site.targets.iter().filter_map(|target| summaries.get(*target));
            let mut ways = known.flat_map(|summary| summary.halves.iter().flat_map(BTreeMap::values).flatten());
            let resets = lent.peek().is_some() && ways.any(|way| way.reset);
            resets || site.targets.is_empty() && lent.any(is_copy)
        }
        _ => false,
    });
    if is_made_of_others { BTreeSet::new() } else { found }
}

/// Whether a filter's place gets what was there before, where `is_copy` says where that may lie.
pub(super) fn is_back(aliases: &Aliases, filter: &Place, set: &Assignment, is_copy: impl Fn(&Place) -> bool) -> bool {
    let Some(from) = &set.from else { return false };
    let gets_back = |place: &Place| match place.relate(filter, &|_| None) {
        Relation::Holds(rest) => {
            let part = from.join(&rest);
            part != *filter && is_copy(&part)
        }
        _ => false,
    };
    // Another name writes nothing.
    gets_back(&set.place) || !set.rebinds && aliases.shared_roots(&set.place).iter().any(gets_back)
}

/// What a function has to do with, owners of which it carries a filter over by the filters in them: they do not share what happens.
pub(super) fn by_filters(
    index: &Index,
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    summaries: &Summaries,
    touched: BTreeSet<Given>,
) -> BTreeSet<Given> {
    let sets = graph.nodes.iter().filter_map(|node| match &node.effect {
        Effect::Set(set) | Effect::Write(set) if set.from.is_some() => Some(&**set),
        _ => None,
    });
    let sets: Vec<&Assignment> = sets.collect();
    let mut found = BTreeSet::new();
    for whole in touched {
        let owner = instance_of(graph, &whole);
        let concerns = |root: &Place| owner.lies_at(root) || root.lies_at(&owner);
        let gives = |set: &&&Assignment| aliases.shared_roots(&set.place).iter().any(concerns);
        let given_anew: Vec<&Assignment> = sets.iter().filter(gives).copied().collect();
        let ty = (!given_anew.is_empty()).then(|| place_ty(index, graph, &owner)).flatten();
        let filters: Vec<Place> = ty
            .filter(|ty| index.filter_spec(ty).is_none())
            .map(|ty| leaves_and_payloads(index, ty.peel()).iter().map(|leaf| owner.join(&leaf.steps)).collect())
            .unwrap_or_default();
        let is_carried = |filter: &Place| {
            let copies = copies(graph, summaries, filter, None);
            given_anew.iter().any(|set| is_back(aliases, filter, set, |part| copies.contains(part)))
        };
        if filters.iter().any(is_carried) {
            found.extend(filters.iter().filter_map(|filter| given(graph, filter)));
        } else {
            found.insert(whole);
        }
    }
    found
}
