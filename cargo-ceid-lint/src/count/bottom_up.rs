//! In which order functions are summarised: callees first, those that do not call each other side by side, and those that do until
//! they no longer change.

use std::collections::BTreeMap;

use super::callgraph::{by_return, calls_itself, levels};
use super::given::MAX_PLACES;
use super::summary::{MAX_STATES, Outcome, Summaries};
use crate::flow::{Cause, ControlFlowGraph, Program};
use crate::index::FunctionId;

/// How often a cycle of calls is gone round.
const MAX_ROUNDS: u32 = 8;

impl Summaries {
    /// Computes the summaries of all functions, callees first; those that do not call each other side by side.
    pub(super) fn compute(program: &Program<'_>, graphs: &[Option<ControlFlowGraph>]) -> Self {
        let mut summaries = Self::default();
        for level in levels(graphs) {
            let (recursive, plain): (Vec<_>, Vec<_>) = level
                .into_iter()
                .partition(|component| component.len() > 1 || component.iter().any(|id| calls_itself(graphs, *id)));
            let plain: Vec<&ControlFlowGraph> =
                plain.iter().flatten().filter_map(|id| graphs[id.0 as usize].as_ref()).collect();
            let found = program.cores.deeply(plain.len(), |at| summaries.summarise(program, plain[at], &mut 0));
            summaries.of.extend(plain.iter().map(|graph| graph.function).zip(found));
            for component in recursive {
                summaries.settle(program, graphs, by_return(graphs, component));
            }
        }
        summaries
    }

    /// Computes the summaries of functions that call each other, until they no longer change.
    fn settle(&mut self, program: &Program<'_>, graphs: &[Option<ControlFlowGraph>], component: Vec<FunctionId>) {
        self.open = component.iter().copied().collect();
        self.is_recursion = true;
        let mut searched = 0;
        for round in 0..MAX_ROUNDS {
            let mut changed = false;
            let mut is_too_wide = false;
            for id in &component {
                let Some(graph) = &graphs[id.0 as usize] else { continue };
                let summary = self.summarise(program, graph, &mut searched);
                if self.of.get(id) != Some(&summary) {
                    is_too_wide |= summary.given_places().count() > MAX_PLACES * summary.laws().max(1);
                    self.of.insert(*id, summary);
                    changed = true;
                }
            }
            if !changed {
                break;
            }
            // Types that hold each other have more places in each round: the next one has many times as many.
            if round + 1 == MAX_ROUNDS || searched > MAX_STATES || is_too_wide {
                self.give_up(&component);
                break;
            }
        }
        self.open.clear();
        self.is_recursion = false;
    }

    /// A recursion that does not settle: nothing is known of what it touches.
    fn give_up(&mut self, component: &[FunctionId]) {
        for id in component {
            let Some(summary) = self.of.get_mut(id) else { continue };
            for outcomes in summary.halves.iter_mut().flat_map(BTreeMap::values_mut) {
                *outcomes = vec![Outcome::unknown(too_many_ways(true))];
            }
        }
    }
}

/// Why functions are not followed to their end: they call each other, or have to do with many filters on many paths.
pub(super) fn too_many_ways(is_recursion: bool) -> Cause {
    let limit = match is_recursion {
        true => "the recursion is too deep to be followed",
        false => "the function has too many paths for its many filters",
    };
    Cause::Limit(limit.to_owned())
}
