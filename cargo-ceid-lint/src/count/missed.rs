//! Filters that no path of a cycle updates.

use super::analyse::CycleId;
use super::counts::Count;
use super::decide::{Decision, head_of, kept_elsewhere};
use super::declared::declared_ty;
use super::gates::Gates;
use super::given::GivenBase;
use super::laws::law_name;
use super::search::{End, EndKind, Exploration, Region, Search};
use super::stand_ins;
use super::taken_out;
use super::verdict::{Gate, Pair, Verdict};
use super::witness::OF_COPY;
use crate::diagnostic::WitnessStep;
use crate::flow::{CallSite, Cause, Effect, NodeId, Place, Transfer, Unrun, UnrunKind};
use crate::source::Span;

/// How code is told of that nothing runs, by what would have to.
pub const UNCONSUMED: &str = "nothing consumes what `";
pub const UNCALLED: &str = "nothing calls this closure";
pub const UNAWAITED: &str = "nothing awaits this future";

/// How all of these end.
const NEVER_RUNS: &str = ", so that it never runs";

/// Decides a pair that is owed an update and that nothing known updates.
pub(super) fn decide_missed(search: &Search<'_>, region: Region, head: Span) -> Decision {
    let exploration = search.explore(region, &search.starts(region));
    let cause = exploration
        .ends
        .iter()
        .find_map(|end| end.state.unknown)
        .map(|cause| exploration.causes[cause as usize].clone());
    let completes = exploration.limit || exploration.ends.iter().any(|end| end.kind == EndKind::Completes);
    let base = Decision {
        verdict: Verdict::Unproved,
        counts: vec![0],
        gate: None,
        cause,
        witness: Vec::new(),
        primary: Some(head),
        through: None,
        others: Vec::new(),
        skips: false,
        law: law_name(search),
    };
    // A helper is told by a constant with a name, which another build may have otherwise, not to update.
    let is_switched_off = |end: &End| end.kind != EndKind::Completes || end.state.helper_gate == Some(Gate::Config);
    match (&base.cause, completes) {
        (Some(_), _) => base,
        (None, true) if !exploration.limit && exploration.ends.iter().all(is_switched_off) => {
            Decision { verdict: Verdict::Gated, gate: Some(Gate::Config), primary: None, ..base }
        }
        (None, true) => missed(search, region, head, base),
        // Only a path that completes owes an update.
        (None, false) => Decision { verdict: Verdict::Once, counts: Vec::new(), ..base },
    }
}

/// The pairs of one instance but for the cycles that turn out never to come to its update, where another one does, here or in another
/// function: they owe it nothing. `for frame in side { run(Some(frame)) } for frame in frames { run(None) }`, where `run` updates
/// without a side only. An element is owed by what updates the others.
pub(super) fn without_those_of_others(
    place: &Place,
    mut decided: Vec<(CycleId, Pair)>,
    is_updated_elsewhere: impl Fn() -> bool,
) -> Vec<(CycleId, Pair)> {
    let is_never = |pair: &Pair| pair.verdict == Verdict::Missed && !pair.updates.is_empty();
    let is_element = place.steps.iter().any(|step| step.key().is_some());
    if !is_element && decided.iter().any(|(_, pair)| is_never(pair)) {
        let is_updated_here = decided.iter().any(|(_, pair)| pair.counts.iter().any(|count| *count > 0));
        if is_updated_here || is_updated_elsewhere() {
            decided.retain(|(_, pair)| !is_never(pair));
        }
    }
    decided
}

/// What no way of a cycle updates: missed, if it is not switched off.
pub(super) fn missed_or_off(
    search: &Search<'_>,
    region: Region,
    exploration: &Exploration,
    completing: &[&End],
    base: Decision,
) -> Decision {
    if is_switched_off(search, region, exploration, completing) {
        return Decision { verdict: Verdict::Gated, gate: Some(Gate::Config), ..base };
    }
    missed(search, region, head_of(search, region), base)
}

/// Whether an element of its own name is updated where a constant or a written row of a table says that it is not to be.
fn is_switched_off(search: &Search<'_>, region: Region, exploration: &Exploration, completing: &[&End]) -> bool {
    let names_it = |id: NodeId| match &search.graph.node(id).effect {
        Effect::Update(update) => search.aliases.shared_roots(&update.place).contains(search.instance),
        Effect::Call(_) => true,
        _ => false,
    };
    let gates = Gates::new(search, region);
    search.updating().into_iter().any(names_it)
        && completing.iter().all(|end| gates.of_end(exploration, end) == Some(Gate::Config))
}

/// Where the law runs and what it gives back is dropped, what is missed is that.
pub(super) fn with_dropped(search: &Search<'_>, mut decision: Decision) -> Decision {
    let dropped = search.dropped().into_iter().next().map(|id| search.graph.node(id).span);
    let message = "the state that the law gives back is dropped here".to_owned();
    decision.witness.extend(dropped.map(|span| WitnessStep { span, message }));
    decision
}

pub(super) fn missed(search: &Search<'_>, region: Region, head: Span, base: Decision) -> Decision {
    let kept = || kept_elsewhere(search).cloned().or_else(|| named_again(search));
    if let Some(cause) = stand_ins::of(search, region).or_else(|| taken_out::of(search, region)).or_else(kept) {
        return Decision { primary: Some(head), counts: base.counts, law: base.law, ..Decision::unproved(cause) };
    }
    if is_empty_slot(search) {
        let name = search.graph.place_name(search.program.index, search.instance);
        let cause = Cause::Code(format!("what `{name}` refers to"));
        return Decision { primary: Some(head), counts: base.counts, law: base.law, ..Decision::unproved(cause) };
    }
    let begins = WitnessStep { span: head, message: "no path of this cycle updates it".to_owned() };
    let witness = [begins].into_iter().chain(unrun(search, region)).chain(copied(search, region)).collect();
    Decision { verdict: Verdict::Missed, witness, primary: Some(head), ..base }
}

/// Why a closure that nothing is seen to run may run all the same: its variable is named where that is not followed.
fn named_again(search: &Search<'_>) -> Option<Cause> {
    let is_it = |place: &Place| search.aliases.shared_roots(place).iter().any(|root| root.overlaps(search.instance));
    let mut unrun = search.graph.unrun.iter().filter(|unrun| unrun.is_named_again);
    let is_lent = unrun.any(|unrun| unrun.places.iter().any(is_it));
    is_lent.then(|| Cause::Code("a closure that goes on under another name".to_owned()))
}

/// The code in a region that would have to do with the instance and that nothing runs.
fn unrun(search: &Search<'_>, region: Region) -> Option<WitnessStep> {
    let graph = search.graph;
    let is_inside = |unrun: &&Unrun| region.holds(graph, unrun.in_loop);
    let is_lent = |place: &Place| search.aliases.shared_roots(place).iter().any(|root| root.overlaps(search.instance));
    let found = graph.unrun.iter().filter(is_inside).find(|unrun| unrun.places.iter().any(is_lent))?;
    let message = match &found.what {
        UnrunKind::Iterator(adaptor) => format!("{UNCONSUMED}{adaptor}` gives{NEVER_RUNS}"),
        UnrunKind::Closure => format!("{UNCALLED}{NEVER_RUNS}"),
        UnrunKind::Future => format!("{UNAWAITED}{NEVER_RUNS}"),
    };
    Some(WitnessStep { span: found.span, message })
}

/// The first call in a region that updates a copy of the instance, which it is passed by value.
fn copied(search: &Search<'_>, region: Region) -> Option<WitnessStep> {
    let graph = search.graph;
    let is_inside = |id: &NodeId| region.holds(graph, graph.node(*id).in_loop);
    let is_it = |place: &Place| search.aliases.shared_roots(place).iter().any(|root| root.overlaps(search.instance));
    // What a call takes by value is copied right before it.
    let copied_for = |call: NodeId| {
        let span = graph.node(call).span;
        graph.nodes.iter().filter(move |node| node.span == span).filter_map(|node| match &node.effect {
            Effect::Set(set) if set.transfer == Transfer::Copy => set.from.as_ref(),
            _ => None,
        })
    };
    let updates = |site: &CallSite, number: usize, from: &Place| {
        let summaries = site.targets.iter().filter_map(|target| search.summaries.get(*target));
        summaries.flat_map(|summary| summary.outcomes(search.law)).any(|(given, ways)| {
            given.base == GivenBase::Param(number)
                && ways.iter().any(|way| way.count != Count::Zero)
                && is_it(&from.join(&given.steps))
        })
    };
    let copies = |call: NodeId, site: &CallSite| {
        let mut taken = site.args.iter().enumerate().filter(|(_, arg)| arg.is_copy);
        taken.any(|(number, _)| copied_for(call).any(|from| updates(site, number, from)))
    };
    let call = graph.node_ids().filter(is_inside).find(|id| match &graph.node(*id).effect {
        Effect::Call(site) => copies(*id, site),
        _ => false,
    })?;
    Some(WitnessStep { span: graph.node(call).span, message: OF_COPY.to_owned() })
}

/// Whether the instance is only what a part of a value made here refers to, if to anything: `Bench { current: None }`.
fn is_empty_slot(search: &Search<'_>) -> bool {
    let (index, graph, place) = (search.program.index, search.graph, search.instance);
    let is_own = place.base_var().is_some_and(|var| graph.var(var).param.is_none());
    let refers = || declared_ty(index, graph, place).is_some_and(|ty| index.refers_to_filters(&ty));
    is_own && !place.steps.is_empty() && refers()
}
