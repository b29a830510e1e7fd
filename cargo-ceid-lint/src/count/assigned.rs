//! Filters that a helper gives the state of others: `fn save(&mut self) { self.saved = self.lag; }`.

use std::collections::BTreeSet;

use super::aliases::Aliases;
use super::given::{Given, GivenBase, MAX_PLACES, given, place_of};
use super::summary::{Summaries, Summary};
use super::uses::{is_plain, originals};
use crate::flow::{CallSite, ControlFlowGraph, Effect, Place, Transfer};
use crate::index::Index;

/// A place that is given a copy of a filter.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Assigned {
    pub(super) to: Given,
    pub(super) from: Given,
    /// Whether nothing else is done with what it is a copy of.
    pub(super) is_all: bool,
}

/// The places that a function, or what it calls, gives copies of filters.
pub(super) fn find(
    index: &Index,
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    summaries: &Summaries,
) -> BTreeSet<Assigned> {
    let mut pairs: BTreeSet<(Place, Place)> = BTreeSet::new();
    let mut add = |to: &Place, from: &Place| {
        let (to, from) = (aliases.shared_roots(to), aliases.shared_roots(from));
        pairs.extend(to.iter().flat_map(|to| from.iter().map(|from| (to.clone(), from.clone()))));
    };
    for node in &graph.nodes {
        match &node.effect {
            Effect::Write(write) => {
                let Some(from) = write.from.as_ref().filter(|from| !is_plain(index, graph, from)) else { continue };
                let is_copy = matches!(write.transfer, Transfer::Copy | Transfer::RoundTrip);
                let all = originals(graph, from);
                all.iter().skip(usize::from(!is_copy)).for_each(|original| add(&write.place, original));
            }
            Effect::Call(site) => of_call(summaries, site).for_each(|(to, from)| add(&to, &from)),
            _ => {}
        }
    }
    if pairs.len() > MAX_PLACES {
        return BTreeSet::new();
    }
    let known = pairs.iter().filter_map(|(to, from)| {
        let is_all = !is_looked_into(graph, aliases, summaries, from);
        Some(Assigned { to: given(graph, to)?, from: given(graph, from)?, is_all })
    });
    known.collect()
}

/// Whether a function does something with a filter but copy it: reads a part of it, or calls something with it.
fn is_looked_into(graph: &ControlFlowGraph, aliases: &Aliases, summaries: &Summaries, filter: &Place) -> bool {
    graph.nodes.iter().any(|node| match &node.effect {
        Effect::Use { place } => aliases
            .shared_roots(place)
            .iter()
            .any(|root| root.overlaps(filter) && root.steps.len() > filter.steps.len()),
        Effect::Update(update) => aliases.shared_roots(&update.place).iter().any(|root| root.overlaps(filter)),
        Effect::Call(site) => (0..site.args.len()).any(|number| does_more(aliases, summaries, site, number, filter)),
        _ => false,
    })
}

/// Whether a call does something with a filter that it gets, or that lies in what it gets, other than to copy it.
pub(super) fn does_more(
    aliases: &Aliases,
    summaries: &Summaries,
    site: &CallSite,
    number: usize,
    filter: &Place,
) -> bool {
    let Some(arg) = site.args.get(number).and_then(|arg| arg.place.as_ref()) else { return false };
    let roots = aliases.shared_roots(arg);
    let mut held = roots.iter().filter(|root| root.overlaps(filter)).peekable();
    if held.peek().is_none() {
        return false;
    }
    let is_it = |given: &Given| {
        let is_filter = |place: Place| aliases.shared_roots(&place).iter().any(|root| root.overlaps(filter));
        given.base == GivenBase::Param(number) && place_of(given, site).is_none_or(is_filter)
    };
    let does = |callee: &Summary| {
        let is_only_copied = |used: &Given| callee.assigns.iter().any(|own| own.is_all && own.from == *used);
        let used = callee.uses.iter().filter(|used| !is_only_copied(used));
        callee.given_places().chain(used).chain(&callee.writes).any(is_it)
    };
    site.targets.is_empty()
        || held.any(|root| root.steps.len() >= filter.steps.len())
        || site.targets.iter().any(|target| summaries.get(*target).is_none_or(does))
}

/// What a call gives copies of filters, and what these are copies of, by the places of the function that calls.
pub(super) fn of_call<'a>(summaries: &'a Summaries, site: &'a CallSite) -> impl Iterator<Item = (Place, Place)> + 'a {
    let callees = site.targets.iter().filter_map(|target| summaries.get(*target));
    callees
        .flat_map(|callee| &callee.assigns)
        .filter_map(|own| Some((place_of(&own.to, site)?, place_of(&own.from, site)?)))
}
