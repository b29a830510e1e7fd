//! Functions that do what the law of their filter does: a filter that a cycle only runs by one of them does not stand still, but its
//! law does not run either.

use std::collections::BTreeSet;

use super::aliases::Aliases;
use super::given::{Given, GivenBase, MAX_PLACES, note, place_of};
use super::instances::inner;
use super::search::{Region, Search};
use super::summary::Summary;
use crate::flow::{CallSite, Cause, ControlFlowGraph, Effect, Program, Steps, stands_in, stands_in_for_states};

/// Says of a function that stands in for a law that it does.
pub(super) fn add(program: &Program<'_>, graph: &ControlFlowGraph, summary: &mut Summary) {
    let index = program.index;
    let id = index.origin(graph.function);
    let cause = |law: &str| Cause::Limit(format!("`{}` writes what the law `{law}` advances", index.function(id).name));
    for (number, half, law) in stands_in_for_states(program, id) {
        let state = Given { base: GivenBase::Param(number), steps: Steps::default() };
        summary.stand_ins.insert((state, half), cause(&law));
    }
    let Some(receiver) = graph.params.first().filter(|_| index.function(id).function.receiver.is_some()) else {
        return;
    };
    for (half, law) in stands_in(program, id, &inner(&graph.var(*receiver).ty)) {
        let whole = Given { base: GivenBase::Param(0), steps: Steps::default() };
        summary.stand_ins.insert((whole, half), cause(&law));
    }
}

/// Says the same of a function that calls such methods.
pub(super) fn pass_on(
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    site: &CallSite,
    callee: &Summary,
    summary: &mut Summary,
) {
    for ((given, half), cause) in &callee.stand_ins {
        let mut places = BTreeSet::new();
        if let Some(place) = place_of(given, site).filter(|_| summary.stand_ins.len() < MAX_PLACES) {
            note(graph, aliases, &place, &mut places);
        }
        summary.stand_ins.extend(places.into_iter().map(|given| ((given, *half), cause.clone())));
    }
}

/// Why it cannot be said that nothing advances the filter: what stands in for its law.
pub(super) fn of(search: &Search<'_>, region: Region) -> Option<Cause> {
    let is_inside = |in_loop| region.holds(search.graph, in_loop);
    let is_it = |given: &Given, site: &_| {
        let place = place_of(given, site);
        place.is_some_and(|place| search.aliases.shared_roots(&place).iter().any(|root| root.overlaps(search.instance)))
    };
    search.graph.nodes.iter().filter(|node| is_inside(node.in_loop)).find_map(|node| {
        let Effect::Call(site) = &node.effect else { return None };
        let callees = site.targets.iter().filter_map(|target| search.summaries.get(*target));
        let mut all = callees.flat_map(|callee| &callee.stand_ins);
        all.find(|((given, half), _)| *half == search.law && is_it(given, site)).map(|(_, cause)| cause.clone())
    })
}
