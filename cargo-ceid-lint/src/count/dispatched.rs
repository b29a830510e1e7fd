//! Calls of which a trait object or type parameter decides which of very many bodies runs: that the receiver's filters may be updated
//! there is known, and nothing else.

use std::collections::BTreeSet;

use super::aliases::Aliases;
use super::behind::types_behind;
use super::callgraph::{callees, components};
use super::counts::Count;
use super::given::{Given, GivenBase};
use super::instances::place_ty;
use super::outcome::Outcome;
use super::summary::Summaries;
use crate::flow::{CallSite, Cause, ControlFlowGraph, Effect, MAX_DISPATCHED, NodeId, Place, Projection};
use crate::index::{FunctionId, Index, Owner, Shape, TraitName, Ty};

/// Says of the receivers of such calls that what happens in them is unknown.
pub(super) fn mark(index: &Index, graphs: &mut [Option<ControlFlowGraph>]) {
    leave_laws(graphs);
    let is_dispatched = |site: &CallSite| site.is_dispatched && site.law_of.is_none();
    let any = graphs.iter().flatten().any(|graph| calls(graph).any(|(_, site)| is_dispatched(site)));
    if !any {
        return;
    }
    let updating = updating(graphs);
    let hides = |target: &FunctionId| {
        let may_hold = match index.function(*target).owner {
            Owner::Impl(of) => index.holds_filter(&index.impl_def(of).self_ty),
            Owner::Trait(_) | Owner::Module => true,
        };
        may_hold && updating.contains(&(target.0 as usize))
    };
    for graph in graphs.iter_mut().flatten() {
        let hiding: Vec<(usize, Place)> = calls(graph)
            .filter(|(_, site)| is_dispatched(site) && site.targets.iter().any(hides))
            .filter_map(|(at, site)| Some((at, site.args.first().filter(|arg| !arg.is_shared)?.place.clone()?)))
            .collect();
        for (at, place) in hiding {
            let call = graph.nodes[at].clone();
            let id = NodeId(u32::try_from(graph.nodes.len()).unwrap_or(u32::MAX));
            graph.nodes.push(call);
            graph.nodes[at].effect = Effect::Unknown { places: vec![place], cause: too_many() };
            graph.nodes[at].next = vec![id];
        }
    }
}

/// Follows none of the bodies of a law where a type parameter still decides which of very many it is.
fn leave_laws(graphs: &mut [Option<ControlFlowGraph>]) {
    for node in graphs.iter_mut().flatten().flat_map(|graph| &mut graph.nodes) {
        if let Effect::Call(site) = &mut node.effect
            && site.law_of.is_some()
            && site.is_dispatched
            && site.targets.len() > MAX_DISPATCHED
        {
            site.targets.clear();
        }
    }
}

/// Why it is not known what such a call does.
pub(super) fn too_many() -> Cause {
    Cause::Limit("too many types may be behind the trait".to_owned())
}

/// What is known by a trait alone, where too many types may be behind that to tell what is updated in it.
pub(super) fn hidden_at(
    index: &Index,
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    place: &Place,
    cause: &Cause,
) -> Vec<Place> {
    let mut roots = if *cause == too_many() { aliases.roots(place) } else { Vec::new() };
    let is_open = |ty: Ty| matches!(ty, Ty::Opaque(_) | Ty::Param(_));
    roots.retain(|root| place_ty(index, graph, root).is_some_and(is_open));
    roots
}

/// The trait objects and the like that a place lies behind, where a filter may be that nothing but its own type tells: what is not
/// known of its parts is told of it as a whole.
pub(super) fn filters_before(index: &Index, graph: &ControlFlowGraph, aliases: &Aliases, place: &Place) -> Vec<Place> {
    let is_open = |whole: &Place| matches!(place_ty(index, graph, whole), Some(Ty::Opaque(_) | Ty::Param(_)));
    let wholes = aliases.roots(place).into_iter().filter_map(|root| {
        let mut before = (0..root.steps.len()).map(|at| root.up_to(at));
        before.find(is_open)
    });
    wholes.filter(|whole| !types_behind(index, graph, whole).is_empty()).collect()
}

/// Whether a call that [`mark`] has marked at a node is one update of whatever is there, all the same: each of the bodies is the law of
/// its type, or updates once whatever lies in a value of its type.
pub(super) fn is_one_update(
    index: &Index,
    graph: &ControlFlowGraph,
    summaries: &Summaries,
    marked: NodeId,
    half: usize,
) -> bool {
    let next = graph.node(marked).next.first().map(|next| &graph.node(*next).effect);
    let Some(Effect::Call(site)) = next else { return false };
    let is_one = |outcomes: &Vec<Outcome>| {
        let is_told = |outcome: &Outcome| outcome.unknown.as_ref().is_none_or(|cause| *cause == too_many());
        !outcomes.is_empty() && outcomes.iter().all(|outcome| outcome.count == Count::One && is_told(outcome))
    };
    let is_law = |target: &FunctionId| match index.function(*target).owner {
        Owner::Impl(of) => index.law_run_by(&index.impl_def(of).self_ty, *target).is_some(),
        Owner::Trait(_) | Owner::Module => false,
    };
    let some_law = site.targets.iter().any(is_law);
    some_law && site.targets.iter().all(|target| {
        let Owner::Impl(of) = index.function(*target).owner else { return false };
        let Some(summary) = summaries.get(*target) else { return summaries.is_open(*target) };
        let Some(ways) = summary.halves.get(half) else { return false };
        let ty = &index.impl_def(of).self_ty;
        let mut own = ways.iter().filter(|(given, _)| given.base == GivenBase::Param(0));
        match (index.law_run_by(ty, *target), ty) {
            (Some((_, law)), _) => law == half && own.any(|(given, ways)| given.steps.is_empty() && is_one(ways)),
            (None, Ty::Adt(id, _)) => {
                let own: Vec<_> = own.collect();
                let is_updated = |field: &str| {
                    let is_in = |given: &Given| matches!(given.steps.first(), Some(Projection::Field(name)) if **name == *field);
                    own.iter().any(|(given, _)| is_in(given))
                };
                let Shape::Struct(of_type) = &index.type_def(*id).shape else { return !index.holds_filter(ty) };
                own.iter().all(|(_, ways)| is_one(ways))
                    && of_type.fields.iter().all(|field| {
                        let is_open = |ty: Ty| index.holds_filter(&ty) || ty.has_part(&mut |part| is_by_trait(part));
                        is_updated(&field.name) || !index.field_ty(ty, None, &field.name).is_some_and(is_open)
                    })
            }
            // A pointer or a reference is what it leads to.
            (None, _) => own.any(|(given, ways)| given.steps.is_empty() && is_one(ways)),
        }
    })
}

/// Whether a trait of the analysed code is all that is known of a type.
fn is_by_trait(ty: &Ty) -> bool {
    let bounds = match ty {
        Ty::Param(param) => &param.bounds,
        Ty::Opaque(bounds) => &**bounds,
        _ => return false,
    };
    bounds.iter().any(|bound| matches!(bound.name, TraitName::Local(_)))
}

fn calls(graph: &ControlFlowGraph) -> impl Iterator<Item = (usize, &CallSite)> {
    graph.nodes.iter().enumerate().filter_map(|(at, node)| match &node.effect {
        Effect::Call(site) => Some((at, &**site)),
        _ => None,
    })
}

/// The functions that update something, at any depth.
fn updating(graphs: &[Option<ControlFlowGraph>]) -> BTreeSet<usize> {
    let updates = |effect: &Effect| matches!(effect, Effect::Update(_) | Effect::Advance(_));
    let mut found: BTreeSet<usize> = BTreeSet::new();
    // Callees come first.
    for component in components(graphs) {
        let mut own = component.iter().filter_map(|id| graphs[id.0 as usize].as_ref());
        if own.any(|graph| {
            graph.nodes.iter().any(|node| updates(&node.effect))
                || callees(graph).iter().any(|callee| found.contains(callee))
        }) {
            found.extend(component.iter().map(|id| id.0 as usize));
        }
    }
    found
}
