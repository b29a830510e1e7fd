//! Filters that a function gives back when its own cycles are done with them: `let level = measured(blocks);`. They are owed
//! nothing more where they arrive.

use std::collections::BTreeSet;

use super::aliases::Aliases;
use super::analyse::FunctionFacts;
use super::counts::Count;
use super::cycles::Instance;
use super::given::{Given, note, place_of};
use super::summary::{Summaries, Summary};
use crate::flow::{ControlFlowGraph, Effect, Place, Steps, Transfer, Var};

/// How many moves in a row are followed.
const MAX_MOVES: usize = 16;

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
    let updated = updated(graph, aliases, summaries);
    let mut found = BTreeSet::new();
    for result in results {
        let own = updated.iter().filter(|root| root.base == result.base);
        found.extend(own.filter_map(|root| Some(root.steps.strip_prefix(&*result.steps)?.into())));
        let base = result.base_var().filter(|_| result.steps.is_empty());
        found.extend(base.into_iter().flat_map(|var| of_variable(graph, summaries, var)).cloned());
    }
    found
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

/// The same for what a variable is given by a call.
pub(super) fn of_variable<'a>(
    graph: &'a ControlFlowGraph,
    summaries: &'a Summaries,
    var: Var,
) -> impl Iterator<Item = &'a Steps> {
    let moved_from = graph.nodes.iter().filter_map(|node| match &node.effect {
        Effect::Set(set) if set.place == Place::var(var) => set.from.as_ref().filter(|from| from.steps.is_empty()),
        _ => None,
    });
    let sources: BTreeSet<Var> = moved_from.filter_map(Place::base_var).chain([var]).collect();
    let targets = graph.nodes.iter().filter_map(move |node| match &node.effect {
        Effect::Call(site) if sources.contains(&site.result) => Some(&site.targets),
        _ => None,
    });
    targets.flatten().filter_map(|target| summaries.get(*target)).flat_map(|summary| &summary.finished)
}

/// Whether what lies at a place was moved there from where a cycle of this function has updated it: `let settled = lag;`.
pub(super) fn is_moved_on(facts: &FunctionFacts<'_>, place: &Place) -> bool {
    let mut seen = BTreeSet::new();
    let mut open = vec![place.clone()];
    while let Some(at) = open.pop().filter(|_| seen.len() < MAX_MOVES) {
        for node in &facts.graph.nodes {
            let Effect::Set(set) = &node.effect else { continue };
            let rest = at.steps.strip_prefix(&*set.place.steps).filter(|_| set.place.base == at.base);
            let (Some(from), Some(rest), Transfer::Move) = (&set.from, rest, set.transfer) else { continue };
            let source = from.join(rest);
            let is_source = |root: &Place| {
                let is_it = |own: &Instance| own.place == *root && (!own.loops.is_empty() || own.function);
                facts.updated.iter().any(is_it)
            };
            if facts.aliases.shared_roots(&source).iter().any(is_source) {
                return true;
            }
            if seen.insert(source.clone()) {
                open.push(source);
            }
        }
    }
    false
}
