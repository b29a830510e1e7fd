//! Loops that run a filter at a multiple of the rate of their input: each round writes several samples, or makes several of one.

use std::collections::BTreeSet;

use super::decide::decide;
use super::search::{Region, Search};
use super::verdict::Verdict;
use crate::flow::{ChangeKind, Computed, Effect, LoopId, NodeId, Place, RunBy, SampleRead, Var};

/// A law that runs in a round: what it is fed, and what it gives.
struct Step<'g> {
    node: NodeId,
    fed: &'g [Var],
    from: &'g Computed,
    into: &'g [Var],
}

/// Whether the updates of a cycle that are more than one are one for each sample, at a rate of their own.
pub(super) fn runs_by_samples(search: &Search<'_>, region: Region) -> bool {
    fills_in_samples(search, region) || takes_samples_of_block(search, region) || runs_at_finer_steps(search, region)
}

/// Whether each round of a loop feeds a filter one sample and then nothing but constants, which are put between the samples, and
/// writes what each of the updates gives to another element of a block: `out[2 * i + 1] = low.run(0.0);`. Two samples that are
/// fed may belong to two channels.
fn fills_in_samples(search: &Search<'_>, region: Region) -> bool {
    let Region::Loop(id) = region else { return false };
    let Some((counter, steps)) = steps_of(search, id) else { return false };
    let graph = search.graph;
    let samples = steps.iter().filter(|step| !is_constant(step)).count();
    if samples != 1 {
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

/// Whether each round of a loop feeds a filter all the samples of a stretch of one block, one behind another, and keeps at most one of
/// the results: `let y = low.run(input[2 * i]); low.run(input[2 * i + 1]); output[i] = y;`. Where it keeps more, these may be channels,
/// which share no filter.
fn takes_samples_of_block(search: &Search<'_>, region: Region) -> bool {
    let Region::Loop(id) = region else { return false };
    let Some((counter, steps)) = steps_of(search, id) else { return false };
    let graph = search.graph;
    let mut offsets = BTreeSet::new();
    let mut blocks = BTreeSet::new();
    for step in &steps {
        let span = graph.node(step.node).span;
        // `let even = input[2 * i]; low.run(even);`
        let is_fed = |read: &SampleRead| span.contains(read.span) || read.into.iter().any(|var| step.fed.contains(var));
        let reads = graph
            .sample_reads
            .iter()
            .filter(|read| read.counter == counter && usize::try_from(read.factor) == Ok(steps.len()) && is_fed(read));
        let reads: BTreeSet<_> = reads.map(|read| (read.block, read.offset)).collect();
        let [(block, offset)] = reads.into_iter().collect::<Vec<_>>()[..] else { return false };
        blocks.insert(block);
        offsets.insert(offset);
    }
    let kept = steps.iter().filter(|step| !graph.dropped.contains(&graph.node(step.node).span));
    blocks.len() == 1 && offsets.len() == steps.len() && kept.count() <= 1
}

/// The counter of a loop, and the laws that its rounds run, if these are all that update the filter and no choice leads to one.
fn steps_of<'g>(search: &Search<'g>, id: LoopId) -> Option<(Var, Vec<Step<'g>>)> {
    let graph = search.graph;
    let (counter, _) = graph.loop_info(id).counter?;
    let updating = search.updating();
    let is_choice = |node: NodeId| {
        matches!(graph.node(node).effect, Effect::Branch(_)) && graph.loops_around(node).any(|around| around == id)
    };
    let is_plain = |node: NodeId| graph.node(node).in_loop == Some(id) && !search.conditions_of(node).any(is_choice);
    let steps: Vec<Step<'_>> =
        updating.iter().filter(|node| is_plain(**node)).filter_map(|node| step(search, *node)).collect();
    (steps.len() == updating.len() && steps.len() >= 2).then_some((counter, steps))
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

/// Whether a loop of a constant number of rounds is a finer time of its own: it holds all updates, one in each round, and each is fed
/// what the round makes of a state that it moves on itself: `for _ in 0..4 { self.phase += step; low.run(self.phase.sin()); }`.
fn runs_at_finer_steps(search: &Search<'_>, region: Region) -> bool {
    let graph = search.graph;
    let updating = search.updating();
    let own = updating.first().and_then(|node| graph.node(*node).in_loop);
    let Some(id) = own.filter(|id| region != Region::Loop(*id) && graph.loop_info(*id).has_constant_rounds()) else {
        return false;
    };
    let is_fed_anew = |node: &NodeId| {
        graph.node(*node).in_loop == Some(id)
            && step(search, *node).is_some_and(|step| step.fed.iter().any(|var| comes_from_moving(search, *var, id)))
    };
    updating.iter().all(is_fed_anew) && decide(search, Region::Loop(id), false).verdict == Verdict::Once
}

/// Whether a value is made of a state from outside a loop that goes on in each round of it.
fn comes_from_moving(search: &Search<'_>, fed: Var, id: LoopId) -> bool {
    let graph = search.graph;
    let is_inside = |node: NodeId| graph.is_within(graph.node(node).in_loop, id);
    let is_from_outside =
        |place: &Place| place.base_var().is_some_and(|var| !graph.is_within(graph.var(var).in_loop, id));
    let moves = |place: &Place| {
        is_from_outside(place)
            && !place.overlaps(search.instance)
            && graph.node_ids().filter(|node| is_inside(*node)).any(|node| {
                let (Effect::Write(write) | Effect::Set(write)) = &graph.node(node).effect else { return false };
                let Some(change) = graph.changes.get(&node).filter(|_| write.place == *place) else { return false };
                // A number that counts the rounds is no state.
                matches!(change.kind, ChangeKind::Accumulates | ChangeKind::Spends)
                    || !change.kind.counts() && change.computed.places.contains(place)
            })
    };
    let mut seen = BTreeSet::new();
    let mut open = vec![Place::var(fed)];
    while let Some(place) = open.pop() {
        if moves(&place) {
            return true;
        }
        let var = place.base_var().filter(|var| graph.is_within(graph.var(*var).in_loop, id) && seen.insert(*var));
        open.extend(
            var.and_then(|var| graph.computed.get(&var)).into_iter().flat_map(|from| from.places.iter().cloned()),
        );
    }
    false
}
