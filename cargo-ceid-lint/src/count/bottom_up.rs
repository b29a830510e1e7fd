//! In which order functions are summarised: callees first, those that do not call each other side by side, and those that do until
//! they no longer change.

use std::collections::{BTreeMap, BTreeSet};

use super::answering::Answering;
use super::between::Between;
use super::callgraph::{by_return, calls_itself, levels};
use super::given::{Given, GivenBase, given, instance_of};
use super::instances::{inner, may_hold_filter};
use super::outcome::Outcome;
use super::own_methods;
use super::recursive::has_owner_twice;
use super::summary::{Summaries, Summary};
use crate::flow::{Cause, ControlFlowGraph, Place, Program, Projection};
use crate::index::{FunctionId, Shape, Ty};

/// How often a cycle of calls is gone round.
const MAX_ROUNDS: u32 = 8;

/// How many places a function may have where types hold each other.
const MAX_NESTED: usize = 32;

/// The same where functions call each other and no type is seen to hold itself: parts of type parameters.
const MAX_WIDE: usize = 48;

impl Summaries {
    /// Computes the summaries of all functions, callees first; those that do not call each other side by side.
    pub(super) fn compute(program: &Program<'_>, graphs: &[Option<ControlFlowGraph>], answering: Answering) -> Self {
        let mut summaries = Self { answering, ..Self::default() };
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
        summaries.between = Between::of(program, graphs);
        summaries
    }

    /// Whether nothing comes back from a call yet: a recursion begins with the ways that do not recur.
    pub(super) fn is_open(&self, id: FunctionId) -> bool {
        self.open.contains(&id) && !self.of.contains_key(&id)
    }

    /// Computes the summaries of functions that call each other, until they no longer change.
    fn settle(&mut self, program: &Program<'_>, graphs: &[Option<ControlFlowGraph>], component: Vec<FunctionId>) {
        self.open = component.iter().copied().collect();
        self.is_recursion = true;
        let mut searched = 0;
        for round in 0..MAX_ROUNDS {
            let mut changed = false;
            let mut is_too_much = false;
            for id in &component {
                let Some(graph) = &graphs[id.0 as usize] else { continue };
                let summary = self.summarise(program, graph, &mut searched);
                if self.of.get(id) == Some(&summary) {
                    continue;
                }
                changed = true;
                is_too_much |= searched > most_states(true) || is_too_wide(program, graph, &summary);
                self.of.insert(*id, summary);
                // After the first round there is something of each to give up.
                if is_too_much && round > 0 {
                    break;
                }
            }
            if !changed {
                break;
            }
            if is_too_much || round + 1 == MAX_ROUNDS {
                self.give_up(program, graphs, &component);
                break;
            }
        }
        self.open.clear();
        self.is_recursion = false;
    }

    /// A recursion that does not settle: nothing is known of what it touches, and of what the rounds have not come to.
    fn give_up(&mut self, program: &Program<'_>, graphs: &[Option<ControlFlowGraph>], component: &[FunctionId]) {
        let unknown = [Outcome::unknown(too_many_ways(true))];
        let listed = |id: &FunctionId| self.of.get(id).into_iter().flat_map(Summary::given_places);
        let statics: BTreeSet<Given> = component
            .iter()
            .flat_map(listed)
            .filter(|given| matches!(given.base, GivenBase::Static(_)))
            .cloned()
            .collect();
        let is_lent_shared = |graph: &ControlFlowGraph, place: &Given| match place.base {
            GivenBase::Param(param) => {
                let var = graph.params.get(param).map(|var| graph.var(*var));
                var.is_some_and(|info| matches!(info.ty, Ty::Ref(false, _)))
            }
            GivenBase::Static(_) => false,
        };
        // A shared reference updates nothing, unless one of them has to do with a cell behind it.
        let has_cells = component.iter().any(|id| {
            let graph = graphs[id.0 as usize].as_ref();
            graph.is_some_and(|graph| listed(id).any(|place| is_lent_shared(graph, place)))
        });
        for id in component {
            let (Some(graph), Some(summary)) = (&graphs[id.0 as usize], self.of.get_mut(id)) else { continue };
            for outcomes in summary.halves.iter_mut().flat_map(BTreeMap::values_mut) {
                *outcomes = unknown.to_vec();
            }
            let params = graph.params.iter().filter(|param| may_hold_filter(program.index, &graph.var(**param).ty));
            let wholes = params.filter_map(|param| given(graph, &Place::var(*param)));
            let wholes = wholes.filter(|place| has_cells || !is_lent_shared(graph, place));
            let parts = parts_of_own(program, graph);
            let is_own = |given: &Given| parts.is_some() && given.base == GivenBase::Param(0);
            let wholes = wholes.filter(|given| !is_own(given)).chain(statics.iter().cloned());
            for given in wholes.chain(parts.iter().flatten().cloned()) {
                summary.insert(&given, &unknown);
            }
            if parts.is_some() {
                own_methods::add(program.index, graph, summary);
            }
        }
    }
}

/// What lies in the filter whose law a function is: the law advances the filter itself once, whatever it does to that. None where it
/// is no law, or where its filter has no parts with names.
fn parts_of_own(program: &Program<'_>, graph: &ControlFlowGraph) -> Option<Vec<Given>> {
    let index = program.index;
    let ty = inner(&graph.var(*graph.params.first()?).ty);
    let Ty::Adt(id, _) = &ty else { return None };
    let Shape::Struct(of_type) = &index.type_def(*id).shape else { return None };
    index.law_run_by(&ty, index.origin(graph.function))?;
    let may_hold = |name: &&str| index.field_ty(&ty, None, name).is_none_or(|ty| may_hold_filter(index, &ty));
    let names = of_type.fields.iter().map(|field| &*field.name).filter(may_hold);
    let part = |name: &str| Given { base: GivenBase::Param(0), steps: [Projection::Field(name.into())].into() };
    Some(names.map(part).collect())
}

/// Whether functions that call each other have many places already: the next round finds many times as many.
fn is_too_wide(program: &Program<'_>, graph: &ControlFlowGraph, summary: &Summary) -> bool {
    let places: BTreeSet<&Given> = summary.given_places().collect();
    let is_nested = |given: &&Given| has_owner_twice(program.index, graph, &instance_of(graph, given));
    places.len() > MAX_WIDE || places.len() > MAX_NESTED && places.iter().any(is_nested)
}

/// How many states the searches of a function for all its filters may have together. Functions that call each other have fewer for
/// all of them, for they are searched again and again.
pub(super) fn most_states(is_recursion: bool) -> usize {
    if is_recursion { 400_000 } else { 1_200_000 }
}

/// Why functions are not followed to their end: they call each other, or have to do with many filters on many paths.
pub(super) fn too_many_ways(is_recursion: bool) -> Cause {
    let limit = match is_recursion {
        true => "the recursion is too deep to be followed",
        false => "the function has too many paths for its many filters",
    };
    Cause::Limit(limit.to_owned())
}
