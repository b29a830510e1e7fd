//! Filters that a function gives back when its own cycles are done with them: `let level = measured(blocks);`. They are owed
//! nothing more where they arrive.

use std::collections::BTreeSet;

use super::aliases::Aliases;
use super::analyse::FunctionFacts;
use super::counts::Count;
use super::cycles::Instance;
use super::given::{Given, note, place_of};
use super::moves;
use super::summary::{Summaries, Summary};
use crate::flow::{ControlFlowGraph, Effect, Place, Steps};

/// Finds what the cycles of a function update, and which parts of its result they are done with.
pub(super) fn find(graph: &ControlFlowGraph, aliases: &Aliases, summaries: &Summaries, summary: &mut Summary) {
    summary.finished = parts(graph, aliases, summaries);
    let mut looped = looped(graph, aliases, summaries);
    // Asked of nothing else, and what functions that call each other lend each other grows with every round.
    let places: BTreeSet<&Given> = summary.given_places().collect();
    looped.retain(|given| places.contains(given));
    summary.looped = looped;
}

/// The places that the loops of a function update, and those of what it calls.
fn looped(graph: &ControlFlowGraph, aliases: &Aliases, summaries: &Summaries) -> BTreeSet<Given> {
    let mut found = BTreeSet::new();
    for node in &graph.nodes {
        match &node.effect {
            Effect::Update(update) if node.in_loop.is_some() => note(graph, aliases, &update.place, &mut found),
            Effect::Call(site) => {
                for called in aliases.called_places(site, summaries).iter().filter(|_| node.in_loop.is_some()) {
                    if called.outcomes(summaries).iter().any(|outcome| outcome.count != Count::Zero) {
                        note(graph, aliases, &called.place, &mut found);
                    }
                }
                let callees = site.targets.iter().filter_map(|target| summaries.get(*target));
                for place in callees.flat_map(|callee| &callee.looped).filter_map(|given| place_of(given, site)) {
                    note(graph, aliases, &place, &mut found);
                }
            }
            _ => {}
        }
    }
    found
}

/// The parts of a function's result that its cycles have updated, by the steps into the result.
fn parts(graph: &ControlFlowGraph, aliases: &Aliases, summaries: &Summaries) -> BTreeSet<Steps> {
    let returned = graph.nodes.iter().filter_map(|node| match &node.effect {
        Effect::Return(value) => value.place.as_ref(),
        _ => None,
    });
    // A large function may return in hundreds of places.
    let results: BTreeSet<Place> = returned.flat_map(|place| aliases.roots(place)).collect();
    if results.is_empty() {
        return BTreeSet::new();
    }
    let done = done_with(graph, summaries, updated(graph, aliases, summaries));
    let mut found = BTreeSet::new();
    for result in results {
        let own = done.iter().filter(|root| root.base == result.base);
        found.extend(own.filter_map(|root| Some(root.steps.strip_prefix(&*result.steps)?.into())));
    }
    found
}

/// Where what some places hold may have been moved, and what the calls give that are done with it.
fn done_with(graph: &ControlFlowGraph, summaries: &Summaries, updated: BTreeSet<Place>) -> BTreeSet<Place> {
    let given = graph.nodes.iter().filter_map(|node| match &node.effect {
        Effect::Call(site) => Some(site),
        _ => None,
    });
    let given = given.flat_map(|site| {
        let callees = site.targets.iter().filter_map(|target| summaries.get(*target));
        callees.flat_map(|callee| &callee.finished).map(|part| Place::var(site.result).join(part))
    });
    let sources: BTreeSet<Place> = updated.into_iter().chain(given).collect();
    sources.iter().flat_map(|source| moves::reached(graph, summaries, source, false)).collect()
}

/// The places that the cycles of a function update, and those of what it calls.
fn updated(graph: &ControlFlowGraph, aliases: &Aliases, summaries: &Summaries) -> BTreeSet<Place> {
    let mut found = BTreeSet::new();
    for node in &graph.nodes {
        match &node.effect {
            Effect::Update(update) if node.in_loop.is_some() => found.extend(aliases.roots(&update.place)),
            Effect::Call(site) => {
                for called in aliases.called_places(site, summaries).iter() {
                    let is_cycle = |count| match count {
                        Count::Zero => false,
                        Count::One => node.in_loop.is_some(),
                        Count::PerSample | Count::Many => true,
                    };
                    if called.outcomes(summaries).iter().any(|outcome| is_cycle(outcome.count)) {
                        found.extend(aliases.roots(&called.place));
                    }
                }
            }
            _ => {}
        }
    }
    found
}

/// Whether what lies at a place was moved there from where a cycle of this function, or of one that gave it, has updated it:
/// `let settled = lag;`, `let (bias, gain) = calibrate();`, `let imu = Imu::new(bias);`.
pub(super) fn is_moved_on(facts: &FunctionFacts<'_>, summaries: &Summaries, place: &Place) -> bool {
    let is_cycles = |own: &&Instance| !own.loops.is_empty() || own.function;
    let updated = facts.updated.iter().filter(is_cycles).map(|own| own.place.clone()).collect();
    let done = done_with(facts.graph, summaries, updated);
    done.contains(place) || facts.aliases.shared_roots(place).iter().any(|root| done.contains(root))
}
