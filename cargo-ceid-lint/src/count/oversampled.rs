//! Loops that run a filter at a multiple of the rate of their input: each round writes several samples.

use std::collections::BTreeSet;

use super::search::{Region, Search};
use crate::flow::{Computed, Effect, NodeId, RunBy, Var};

/// A law that runs in a round: what it is fed, and what it gives.
struct Step<'g> {
    node: NodeId,
    fed: &'g [Var],
    from: &'g Computed,
    into: &'g [Var],
}

/// Whether each round of a loop feeds a filter one sample and then nothing but constants, which are put between the samples, and
/// writes what each of the updates gives to another element of a block: `out[2 * i + 1] = low.run(0.0);`. Two samples that are
/// fed may belong to two channels.
pub(super) fn fills_in_samples(search: &Search<'_>, region: Region) -> bool {
    let Region::Loop(id) = region else { return false };
    let graph = search.graph;
    let Some((counter, _)) = graph.loop_info(id).counter else { return false };
    let updating = search.updating();
    let is_choice = |node: NodeId| {
        matches!(graph.node(node).effect, Effect::Branch(_)) && graph.loops_around(node).any(|around| around == id)
    };
    let is_plain = |node: NodeId| graph.node(node).in_loop == Some(id) && !search.conditions_of(node).any(is_choice);
    let steps: Vec<Step<'_>> =
        updating.iter().filter(|node| is_plain(**node)).filter_map(|node| step(search, *node)).collect();
    let samples = steps.iter().filter(|step| !is_constant(step)).count();
    if steps.len() != updating.len() || steps.len() < 2 || samples != 1 {
        return false;
    }
    let mut elements = BTreeSet::new();
    let mut blocks = BTreeSet::new();
    for step in &steps {
        let span = graph.node(step.node).span;
        let mut writes = graph.sample_writes.iter().filter(|write| {
            write.counter == counter
                && usize::try_from(write.factor) == Ok(steps.len())
                && write.offset < write.factor
                && (write.value.contains(span) || write.from.iter().any(|var| step.into.contains(var)))
        });
        let (Some(write), None) = (writes.next(), writes.next()) else { return false };
        blocks.insert(write.block);
        elements.insert(write.offset);
    }
    blocks.len() == 1 && elements.len() == steps.len()
}

/// What lies inside a filter its law runs.
fn step<'g>(search: &Search<'g>, node: NodeId) -> Option<Step<'g>> {
    match &search.graph.node(node).effect {
        Effect::Update(update) if update.run_by == RunBy::Code && update.attempt.is_none() => {
            Some(Step { node, fed: &update.fed, from: &update.from, into: &update.into })
        }
        Effect::Call(site) if site.law_of == Some(0) => {
            Some(Step { node, fed: &site.fed, from: &site.from, into: &site.into })
        }
        _ => None,
    }
}

/// Whether a law is fed nothing but constants: `low.run(0.0)`, `low.run(T::zero())`.
fn is_constant(step: &Step<'_>) -> bool {
    let is_made = |call: &String| matches!(call.as_str(), "zero" | "default");
    step.fed.is_empty() && step.from.places.is_empty() && step.from.calls.iter().all(is_made)
}
