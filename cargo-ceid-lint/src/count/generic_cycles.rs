//! The loops of generic functions for the types that they are called with: these tell what lies behind a type parameter.

use std::collections::{BTreeMap, BTreeSet};

use super::callgraph::callees;
use super::dispatched::too_many;
use super::monomorphise::MAX_INSTANCES;
use super::verdict::{Cycle, Pair, Verdict};
use crate::flow::{ControlFlowGraph, CycleKind};
use crate::index::{FunctionId, Index};

/// Whether the loops of an instance are judged beside those of the function as it is written.
pub(super) fn has_cycles(graph: &ControlFlowGraph) -> bool {
    graph.loops.iter().any(|info| info.cycle_head().is_some())
}

/// The generic functions that analysed code calls with known types only.
fn fully_known(index: &Index, graphs: &[Option<ControlFlowGraph>]) -> BTreeSet<FunctionId> {
    let mut known: BTreeSet<FunctionId> = index.instances.iter().copied().collect();
    loop {
        let others = graphs.iter().flatten().filter(|graph| !known.contains(&graph.function));
        let called: BTreeSet<usize> = others.flat_map(callees).collect();
        let before = known.len();
        known.retain(|id| !called.contains(&(id.0 as usize)));
        if known.len() == before {
            return known;
        }
    }
}

/// The generic functions that are called for more types than they have instances: those that are called for too many, and what
/// these call.
fn beyond_limit(
    index: &Index,
    graphs: &[Option<ControlFlowGraph>],
    known: &BTreeSet<FunctionId>,
) -> BTreeSet<FunctionId> {
    let is_limited = |id: &FunctionId| index.instances.iter().filter(|origin| *origin == id).count() >= MAX_INSTANCES;
    let of_many: BTreeSet<FunctionId> = index.instances.iter().copied().filter(|id| !known.contains(id)).collect();
    let mut open: Vec<FunctionId> = of_many.into_iter().filter(is_limited).collect();
    let mut found = BTreeSet::new();
    while let Some(id) = open.pop() {
        if found.insert(id) {
            let called = graphs[id.0 as usize].as_ref().map(callees).into_iter().flatten();
            open.extend(called.filter_map(|id| u32::try_from(id).ok().map(FunctionId)));
        }
    }
    found
}

/// Adds what was found in the loops of instances to what is known of the functions as they are written.
pub(super) fn merge_all(
    index: &Index,
    graphs: &[Option<ControlFlowGraph>],
    written: &mut Vec<Cycle>,
    of_instances: BTreeMap<FunctionId, Vec<Cycle>>,
) {
    let known = fully_known(index, graphs);
    let beyond = beyond_limit(index, graphs, &known);
    for (origin, mut cycles) in of_instances {
        if beyond.contains(&origin) {
            doubt(written, &mut cycles);
        }
        merge(written, cycles, known.contains(&origin));
    }
}

/// What only the instances of a function tell is proved for no other type.
fn doubt(written: &[Cycle], instance: &mut [Cycle]) {
    for cycle in instance {
        let own = written.iter().find(|own| place(own) == place(cycle));
        let is_told = |pair: &Pair| {
            own.is_some_and(|own| own.filters.iter().any(|other| (&other.name, other.half) == (&pair.name, pair.half)))
        };
        for pair in cycle.filters.iter_mut().filter(|pair| !is_told(pair)) {
            if pair.verdict.gravity() < Verdict::Unproved.gravity() {
                pair.verdict = Verdict::Unproved;
                pair.gate = None;
                pair.rules = Verdict::Unproved.rule().into_iter().collect();
                pair.cause = Some(too_many().to_string());
            }
        }
    }
}

/// Where the cycle is.
fn place(cycle: &Cycle) -> impl PartialEq + use<> {
    (cycle.package, cycle.target, cycle.head)
}

/// Adds what was found in the loops of an instance to what is known of others of the function, or of it as it is written; this
/// one gives way where it is called with known types only.
pub(super) fn merge(cycles: &mut Vec<Cycle>, instance: Vec<Cycle>, gives_way: bool) {
    for cycle in instance.into_iter().filter(|cycle| cycle.kind != CycleKind::Function) {
        match cycles.iter_mut().find(|own| place(own) == place(&cycle)) {
            Some(own) => {
                if gives_way {
                    // What is wrong with some other type that may be there is still said.
                    let is_told = |pair: &Pair| cycle.filters.iter().any(|other| other.primary == pair.primary);
                    let is_wrong = |pair: &Pair| pair.verdict.gravity() > Verdict::Unproved.gravity();
                    own.filters.retain(|pair| is_wrong(pair) && !is_told(pair));
                }
                add_pairs(own, cycle.filters);
            }
            None => cycles.push(cycle),
        }
    }
}

fn add_pairs(cycle: &mut Cycle, pairs: Vec<Pair>) {
    for pair in pairs {
        let is_same = |own: &&mut Pair| (&own.name, own.half) == (&pair.name, pair.half);
        match cycle.filters.iter_mut().find(is_same) {
            // What was proved for every type that may be there is not taken back for less than a violation.
            Some(own) if own.verdict == Verdict::Unproved || pair.verdict == Verdict::Repeated => {
                if pair.verdict.gravity() > own.verdict.gravity() {
                    *own = pair;
                }
            }
            Some(_) => {}
            None => cycle.filters.push(pair),
        }
    }
    cycle.filters.sort_by(|left, right| (&left.name, &left.law).cmp(&(&right.name, &right.law)));
}
