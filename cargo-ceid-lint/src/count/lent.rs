//! Filters that functions are lent by whoever updates them.

use std::collections::BTreeSet;

use super::analyse::FunctionFacts;
use super::functions::FunctionKind;
use super::given::place_of;
use super::summary::Summaries;
use crate::flow::{ControlFlowGraph, Effect, Place};
use crate::index::{FunctionId, Index};

/// Parameters, by their numbers, of functions that are somewhere lent what is updated there, or what lies where others update it.
#[derive(Debug, Default)]
pub(super) struct Lent(BTreeSet<(FunctionId, usize)>);

impl Lent {
    pub(super) fn of(index: &Index, summaries: &Summaries, facts: &[FunctionFacts<'_>]) -> Self {
        let mut found = BTreeSet::new();
        for function in facts.iter().filter(|function| function.kind != FunctionKind::Outside) {
            let updated = updated_by_callees(function, summaries);
            for node in &function.graph.nodes {
                let Effect::Call(site) = &node.effect else { continue };
                for (number, arg) in site.args.iter().enumerate() {
                    let lent = arg.place.as_ref().map(|place| function.aliases.shared_roots(place));
                    if lent.is_some_and(|roots| roots.iter().any(|root| is_kept(function, &updated, root))) {
                        found.extend(site.targets.iter().map(|target| (index.origin(*target), number)));
                    }
                }
            }
        }
        Self(found)
    }

    /// Whether a parameter that a place is may be lent by whoever updates it.
    pub(super) fn has(&self, index: &Index, graph: &ControlFlowGraph, place: &Place) -> bool {
        let info = place.base_var().filter(|_| place.steps.is_empty()).map(|var| graph.var(var));
        let number = info.and_then(|info| info.param);
        number.is_some_and(|number| self.0.contains(&(index.origin(graph.function), number)))
    }
}

/// Whether a function updates what it lends, has it updated by another one, or was lent it itself.
fn is_kept(function: &FunctionFacts<'_>, updated: &BTreeSet<Place>, lent: &Place) -> bool {
    let is_own = lent.base_var().is_some_and(|var| function.graph.var(var).param.is_none());
    let mut here = function.updated.iter().map(|instance| &instance.place);
    !is_own || here.any(|place| place.overlaps(lent)) || updated.iter().any(|place| place.overlaps(lent))
}

/// What the functions that a function calls or spawns update, also those that never come back.
fn updated_by_callees(function: &FunctionFacts<'_>, summaries: &Summaries) -> BTreeSet<Place> {
    let mut updated = BTreeSet::new();
    for node in &function.graph.nodes {
        let Effect::Call(site) = &node.effect else { continue };
        let callees = site.targets.iter().filter_map(|target| summaries.get(*target));
        let for_good = callees.flat_map(|callee| &callee.endless).filter_map(|given| place_of(given, site));
        for place in summaries.updates(site).chain(for_good) {
            updated.extend(function.aliases.roots(&place));
        }
    }
    updated
}
