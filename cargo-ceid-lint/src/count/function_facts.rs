//! What is known of each function by itself: its names, its branches, and the cycles of the filters that it updates.

use std::collections::BTreeSet;

use super::aliases::Aliases;
use super::analyse::{FunctionFacts, filters_at, is_debug_only, own_filter};
use super::chosen_resets;
use super::cycles::{Instance, choose_cycles};
use super::debug_only;
use super::dispatched;
use super::functions::FunctionKind;
use super::given::place_of;
use super::handles::Handles;
use super::instances::{place_ty, settle_elements};
use super::search::Search;
use super::slice::ControlDependence;
use super::summary::Summaries;
use crate::flow::{Base, ControlFlowGraph, Effect, LoopId, Place, Program, Projection};
use crate::index::{FunctionId, Index, Shape, Subject, Ty};

/// Finds it.
pub(super) fn function_facts<'a>(
    program: &Program<'a>,
    graph: &'a ControlFlowGraph,
    summaries: &Summaries,
    kind: FunctionKind,
    in_cycle: &BTreeSet<FunctionId>,
) -> FunctionFacts<'a> {
    let aliases = Aliases::of(program.index, graph, summaries);
    let dependence = ControlDependence::of(graph, &aliases);
    let mut places: BTreeSet<Place> = BTreeSet::new();
    // A law may have its state in an argument, whatever the argument's type.
    let mut states: BTreeSet<Place> = BTreeSet::new();
    let mut hiding: BTreeSet<Place> = BTreeSet::new();
    for node in graph.nodes.iter().filter(|node| node.debug_only.is_none()) {
        match &node.effect {
            Effect::Update(update) if !super::handed::is_idle(&aliases, update) => {
                let roots = aliases.roots(&update.place);
                states.extend(roots.iter().filter(|_| !update.is_typed).cloned());
                places.extend(roots);
            }
            Effect::Advance(advance) if advance.is_dropped => states.extend(aliases.roots(&advance.before)),
            Effect::Call(site) => {
                states.extend(summaries.updates(site).flat_map(|place| aliases.roots(&place)));
                for summary in site.targets.iter().filter_map(|target| summaries.get(*target)) {
                    for (given, outcomes) in summary.all_outcomes() {
                        let mut unknown = outcomes.iter().filter_map(|outcome| outcome.unknown.as_ref());
                        if let Some(cause) = unknown.find(|cause| !cause.is_order())
                            && let Some(place) = place_of(given, site)
                        {
                            hiding.extend(dispatched::hidden_at(program.index, graph, &aliases, &place, cause));
                            hiding.extend(dispatched::filters_before(program.index, graph, &aliases, &place));
                            places.extend(filters_at(program.index, graph, &aliases, &place));
                        }
                    }
                }
            }
            Effect::Unknown { places: unknown, cause } if !cause.is_order() => {
                hiding.extend(
                    unknown
                        .iter()
                        .flat_map(|place| dispatched::hidden_at(program.index, graph, &aliases, place, cause)),
                );
                places.extend(unknown.iter().flat_map(|place| filters_at(program.index, graph, &aliases, place)));
            }
            _ => {}
        }
    }
    states.extend(hiding.iter().cloned());
    places.extend(states.iter().cloned());
    places.extend(debug_only::updates(graph, &aliases, summaries).into_iter().map(|update| update.place));
    let own = own_filter(program.index, graph);
    places.retain(|place| {
        own.as_ref() != Some(place)
            && is_instance(program.index, graph, place, states.contains(place))
            && !is_debug_only(graph, place)
    });
    places.extend(chosen_resets::one_by_one(program.index, graph, &aliases, &places));
    let mut updated: Vec<Instance> = Vec::new();
    for place in settle_elements(program.index, graph, &places) {
        let ty = place_ty(program.index, graph, &place);
        let spec = ty.as_ref().and_then(|ty| program.index.filter_spec(ty));
        let halves = spec.map(|spec| spec.law.len()).or(hiding.contains(&place).then_some(1));
        // A cycle that runs one of several functions on a state need not run the others.
        let owes_all = halves.is_some()
            && spec.is_none_or(|spec| spec.law.len() == 1 || !matches!(spec.subject, Subject::Function(_)));
        for law in 0..halves.unwrap_or_else(|| program.index.halves()) {
            let dependence = &dependence;
            let search = Search::with_dependence(program, graph, &aliases, summaries, &place, law, dependence);
            let instance = choose_cycles(graph, &aliases, summaries, &search, kind, in_cycle, &[]);
            // How many halves there are of a state that lies in an argument, its calls tell.
            if owes_all || !search.updating().is_empty() || !search.dropped().is_empty() {
                updated.push(instance);
            }
        }
    }
    let sampled: Vec<LoopId> = updated.iter().flat_map(|instance| &instance.sample_loops).copied().collect();
    for instance in updated.iter_mut().filter(|instance| instance.function && !sampled.is_empty()) {
        let (place, law) = (instance.place.clone(), instance.law);
        let search = Search::with_dependence(program, graph, &aliases, summaries, &place, law, &dependence);
        *instance = choose_cycles(graph, &aliases, summaries, &search, kind, in_cycle, &sampled);
    }
    let function = &program.index.function(graph.function).function;
    let body = function.body.as_ref().map_or(function.head, |body| body.expr(body.root).span);
    let handles = Handles::of(program.index, graph, summaries);
    let is_in_cycle = in_cycle.contains(&graph.function);
    FunctionFacts { graph, aliases, dependence, handles, updated, kind, is_in_cycle, body }
}

/// Whether a place can be judged as an instance of a filter: by its type, unless it is the state of a law.
fn is_instance(index: &Index, graph: &ControlFlowGraph, place: &Place, is_state: bool) -> bool {
    let ty = place_ty(index, graph, place);
    // What a generic function does to filters it does not do to a type that is none.
    let is_other = matches!(ty, Some(Ty::Adt(..))) && !index.has_states_apart();
    let is_filter = ty.is_some_and(|ty| index.filter_spec(&ty).is_some());
    if !is_filter && (!is_state || is_other) {
        return false;
    }
    // What a generic function does to another type's fields does not happen where the type is known.
    let mut at = Place::from(place.base);
    for step in place.steps.iter() {
        let owner = place_ty(index, graph, &at).filter(|_| matches!(step, Projection::Field(_)));
        at = at.join(std::slice::from_ref(step));
        let has_parts = match &owner {
            Some(Ty::Adt(id, _)) => matches!(index.type_def(*id).shape, Shape::Struct(_)),
            Some(Ty::Opaque(_) | Ty::Param(_)) => true,
            _ => false,
        };
        if has_parts && place_ty(index, graph, &at).is_none() {
            return false;
        }
    }
    match place.base {
        Base::Static(_) => true,
        Base::Var(var) => {
            let info = graph.var(var);
            // A value in between that has no name in the source is no instance that a user could be told about.
            !info.name.is_empty() || info.param.is_some()
        }
    }
}
