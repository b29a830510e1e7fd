//! The loops of generic functions for the types that they are called with: these tell what lies behind a type parameter.

use std::collections::BTreeSet;

use super::callgraph::callees;
use super::verdict::{Cycle, Pair, Verdict};
use crate::flow::{ControlFlowGraph, CycleKind};
use crate::index::{FunctionId, Index};

/// Whether the loops of an instance are judged beside those of the function as it is written.
pub(super) fn has_cycles(graph: &ControlFlowGraph) -> bool {
    graph.loops.iter().any(|info| info.cycle_head().is_some())
}

/// The generic functions that analysed code calls with known types only.
pub(super) fn fully_known(index: &Index, graphs: &[Option<ControlFlowGraph>]) -> BTreeSet<FunctionId> {
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

/// Adds what was found in the loops of an instance to what is known of others of the function, or of it as it is written; this
/// one gives way where it is called with known types only.
pub(super) fn merge(cycles: &mut Vec<Cycle>, instance: Vec<Cycle>, gives_way: bool) {
    for cycle in instance.into_iter().filter(|cycle| cycle.kind != CycleKind::Function) {
        let place = |cycle: &Cycle| (cycle.package, cycle.target, cycle.head);
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
