//! What one call of a function is: a control cycle, perhaps one, or a part of whatever calls it.

use std::collections::BTreeSet;

use super::callgraph::callees;
use super::given::{Given, GivenBase};
use super::instances::{may_hold_filter, place_ty};
use super::summary::Summaries;
use crate::flow::{CallSite, ControlFlowGraph, CycleKind, Effect, LoopId, Node, NodeId, Place, Program};
use crate::index::{CrateInfo, FilterSpec, FunctionId, Index, ModuleId, Owner, Subject, TraitName, Ty};
use crate::syntax::CycleDirective;
use crate::syntax::tree::Receiver;

/// What one call of a function is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FunctionKind {
    /// One control cycle.
    Cycle,
    /// Perhaps one control cycle: only what is certainly wrong is said.
    Presumed,
    /// A part of whatever calls it.
    Helper,
    /// Nothing that is looked at: a test.
    Outside,
}

/// The functions that analysed code outside tests calls.
pub(super) fn called_functions(index: &Index, graphs: &[Option<ControlFlowGraph>]) -> BTreeSet<FunctionId> {
    called_by(index, graphs, |caller| !is_outside(index, caller))
}

/// The methods that nothing calls but constructors: their users may call them in each cycle as well, as what sets the attributes of
/// a voice.
pub(super) fn called_while_made(index: &Index, graphs: &[Option<ControlFlowGraph>]) -> BTreeSet<FunctionId> {
    let others = called_by(index, graphs, |caller| !is_outside(index, caller) && !is_constructor(index, caller));
    let mut called = called_by(index, graphs, |caller| is_constructor(index, caller));
    called.retain(|id| {
        let def = index.function(*id);
        def.is_pub_method && def.function.receiver == Some(Receiver::Exclusive) && !others.contains(id)
    });
    called
}

fn called_by(
    index: &Index,
    graphs: &[Option<ControlFlowGraph>],
    is_caller: impl Fn(FunctionId) -> bool,
) -> BTreeSet<FunctionId> {
    graphs
        .iter()
        .flatten()
        .filter(|graph| is_caller(graph.function))
        .flat_map(|graph| {
            let own = graph.function;
            callees(graph)
                .into_iter()
                .map(|callee| FunctionId(u32::try_from(callee).unwrap_or(u32::MAX)))
                .chain(graph.read_here.iter().copied())
                .flat_map(|callee| [callee, index.origin(callee)])
                .filter(move |callee| index.origin(*callee) != index.origin(own))
        })
        .collect()
}

fn is_outside(index: &Index, id: FunctionId) -> bool {
    let def = index.function(id);
    def.is_test || index.crate_of(def.module).is_test
}

/// The functions that run inside some cycle: called from a loop, or from a function that is a cycle, at any depth.
pub(super) fn reached_from_cycles(
    program: &Program<'_>,
    graphs: &[Option<ControlFlowGraph>],
    summaries: &Summaries,
    called: &BTreeSet<FunctionId>,
) -> BTreeSet<FunctionId> {
    let mut reached: BTreeSet<FunctionId> = BTreeSet::new();
    let mut open = Vec::new();
    for graph in graphs.iter().flatten() {
        let kind = function_kind(program, graph, summaries, called);
        let is_cycle = |site: &CallSite| match kind {
            FunctionKind::Cycle => true,
            // One cycle is what it does to the filters of its caller.
            FunctionKind::Presumed => !has_only_own_filters(program.index, graph, site),
            FunctionKind::Helper | FunctionKind::Outside => false,
        };
        for node in &graph.nodes {
            if let Effect::Call(site) = &node.effect
                && (node.in_loop.is_some() || is_cycle(site))
            {
                open.extend(site.targets.iter().copied());
            }
        }
    }
    while let Some(id) = open.pop() {
        if reached.insert(id)
            && let Some(graph) = &graphs[id.0 as usize]
        {
            open.push(program.index.origin(id));
            open.extend(callees(graph).into_iter().map(|callee| FunctionId(u32::try_from(callee).unwrap_or(u32::MAX))));
        }
    }
    reached
}

/// Whether what a call is given of filters was made in the function that calls, of which nobody else sees it.
fn has_only_own_filters(index: &Index, graph: &ControlFlowGraph, site: &CallSite) -> bool {
    let places = site.args.iter().filter_map(|arg| arg.place.as_ref());
    let filters = places.filter(|place| holds_filter(index, graph, place));
    let is_own = |place: &Place| {
        place.base_var().is_some_and(|var| graph.var(var).param.is_none() && matches!(graph.var(var).ty, Ty::Adt(..)))
    };
    let mut filters = filters.peekable();
    filters.peek().is_some() && filters.all(is_own)
}

/// Whether there may be a filter at a place. What a driver of any type may hold besides is nothing that anybody knows of.
fn holds_filter(index: &Index, graph: &ControlFlowGraph, place: &Place) -> bool {
    place_ty(index, graph, place).is_none_or(|ty| match ty.peel() {
        any @ (Ty::Param(_) | Ty::Opaque(_)) => index.filter_spec(any).is_some(),
        known => may_hold_filter(index, known),
    })
}

/// What one call of a function is.
pub(super) fn function_kind(
    program: &Program<'_>,
    graph: &ControlFlowGraph,
    summaries: &Summaries,
    called: &BTreeSet<FunctionId>,
) -> FunctionKind {
    let index = program.index;
    let id = graph.function;
    if is_outside(index, id) {
        return FunctionKind::Outside;
    }
    match program.directive(index.function(id).function.keyword) {
        Some(CycleDirective::Cycle) => return FunctionKind::Cycle,
        Some(CycleDirective::NotACycle) => return FunctionKind::Helper,
        Some(CycleDirective::Every(_)) | None => {}
    }
    if hands_law_on(index, graph) {
        return FunctionKind::Helper;
    }
    if is_cycle_function(index, id) {
        return FunctionKind::Cycle;
    }
    // A function with a loop that never ends is not called once per cycle.
    let is_endless = (0u32..)
        .map(LoopId)
        .zip(&graph.loops)
        .any(|(own, info)| info.is_endless() && !is_passed(program.index, graph, summaries, own));
    if let Owner::Impl(owner) = index.function(id).owner
        && index.guard_spec(&index.impl_def(owner).self_ty).is_some()
    {
        // What a guard does when it ends is counted where it ends.
        return FunctionKind::Helper;
    }
    if !is_endless && index.is_declared_cycle(id) {
        return FunctionKind::Cycle;
    }
    let is_called = called.contains(&id) || program.callables.is_listed(index.origin(id));
    if is_called || is_constructor(index, id) || index.function(id).name == "main" || is_endless {
        return FunctionKind::Helper;
    }
    FunctionKind::Presumed
}

/// Whether a loop that is no count is only passed through on the way: it asks for nothing but a condition, has a way out, and has
/// nothing to do with filters, as one that brings an angle into its range or waits for a flag.
pub(super) fn is_passed(index: &Index, graph: &ControlFlowGraph, summaries: &Summaries, id: LoopId) -> bool {
    let info = graph.loop_info(id);
    let is_inside = |node: NodeId| graph.is_within(graph.node(node).in_loop, id);
    let holds_filter = |place: &Place| holds_filter(index, graph, place);
    let inside: Vec<&Node> = graph.node_ids().filter(|node| is_inside(*node)).map(|node| graph.node(node)).collect();
    let makes_guard = inside.iter().any(|node| matches!(node.effect, Effect::GuardStart(_)));
    let touches = |effect: &Effect| match effect {
        // A guard from outside runs its laws where the loop leaves the cycle around it as well.
        Effect::Update(update) if update.run_by.is_guard() => makes_guard,
        Effect::Update(_) | Effect::Advance(_) | Effect::Reset { .. } => true,
        Effect::Use { place } => holds_filter(place),
        Effect::Set(write) | Effect::Write(write) if !write.place.steps.is_empty() => {
            holds_filter(&Place::from(write.place.base))
        }
        Effect::Unknown { places, .. } => places.iter().any(holds_filter),
        Effect::Call(site) => {
            let mut called = site.targets.iter().map(|target| summaries.get(*target));
            let mut given = site.args.iter().filter_map(|arg| arg.place.as_ref());
            let meets = |place: &Given| match place.base {
                GivenBase::Param(number) => {
                    site.args.get(number).and_then(|arg| arg.place.as_ref()).is_some_and(holds_filter)
                }
                GivenBase::Static(_) => true,
            };
            called.any(|callee| match callee {
                Some(callee) => callee.given_places().chain(&callee.uses).any(meets),
                None => given.any(holds_filter),
            })
        }
        _ => false,
    };
    let leaves =
        |node: &Node| matches!(node.effect, Effect::Return(_)) || node.next.iter().any(|next| !is_inside(*next));
    matches!(info.kind, CycleKind::Loop | CycleKind::While)
        && info.bound.is_empty()
        && inside.iter().any(|node| leaves(node))
        && !inside.iter().any(|node| touches(&node.effect))
}

/// Whether a function is said to be one control cycle, or known to be one.
pub(super) fn is_run_as_cycle(program: &Program<'_>, id: FunctionId) -> bool {
    match program.directive(program.index.function(id).function.keyword) {
        Some(CycleDirective::Cycle) => true,
        Some(CycleDirective::NotACycle) => false,
        Some(CycleDirective::Every(_)) | None => {
            is_cycle_function(program.index, id) || program.index.is_declared_cycle(id)
        }
    }
}

/// Whether a framework calls the function once per cycle, or it is the law of a filter that is made of filters.
#[must_use]
pub fn is_cycle_function(index: &Index, id: FunctionId) -> bool {
    let def = index.function(id);
    let by_attribute = def.attributes.iter().any(|attribute| {
        let last = attribute.path.rsplit("::").next().unwrap_or("");
        // An `async` task runs a loop of its own.
        CYCLE_ATTRIBUTES.contains(&last) || (last == "task" && !def.function.is_async)
    });
    if by_attribute {
        return true;
    }
    let Owner::Impl(impl_id) = def.owner else { return false };
    if let Some(name) = &index.impl_def(impl_id).implements {
        let trait_text = index.trait_text(name);
        if CYCLE_METHODS.iter().any(|(of, method)| *of == trait_text && *method == def.name) {
            return true;
        }
    }
    is_law(index, id)
}

/// Whether a function is the law of a filter: one that it is declared with, or the one by which guards run that.
pub(super) fn is_law(index: &Index, id: FunctionId) -> bool {
    law_of(index, id).is_some() || index.is_run_by_guards(id)
}

/// Whether a law by which guards run a filter does nothing but run the one that the filter is declared with, which is a cycle itself.
fn hands_law_on(index: &Index, graph: &ControlFlowGraph) -> bool {
    let of_self =
        |place: &Place| place.steps.is_empty() && place.base_var().is_some_and(|var| graph.var(var).param == Some(0));
    let is_other_law = |site: &CallSite| {
        let is_whole = site.args.first().and_then(|arg| arg.place.as_ref()).is_some_and(of_self);
        is_whole && site.targets.iter().all(|target| *target != graph.function && law_of(index, *target).is_some())
    };
    let mut calls = 0;
    let is_plain = |effect: &Effect| match effect {
        Effect::Call(site) => {
            calls += 1;
            is_other_law(site)
        }
        Effect::Update(update) => of_self(&update.place),
        Effect::Nothing | Effect::Set(_) | Effect::Return(_) | Effect::End | Effect::Mark(_) => true,
        _ => false,
    };
    index.is_run_by_guards(graph.function) && graph.nodes.iter().map(|node| &node.effect).all(is_plain) && calls == 1
}

/// What is known of the filter whose law a function is.
fn law_of(index: &Index, id: FunctionId) -> Option<&FilterSpec> {
    let def = index.function(id);
    let Owner::Impl(of) = def.owner else { return None };
    let owner = index.impl_def(of);
    // Tuples and rows are no filters by themselves, but what a trait has them do runs those in them.
    let of_row = || match (&owner.self_ty, &owner.implements) {
        (Ty::Tuple(_) | Ty::Array(..) | Ty::Slice(_), Some(name)) => index.law_of_trait(name, &def.name),
        _ => None,
    };
    index.law_run_by(&owner.self_ty, id).map(|(spec, _)| spec).or_else(of_row)
}

/// Why a law is not judged in the crate that brings the filters of a preset, with the way out: a preset tells how others use them, and
/// a law of the crate's own may run what it is made of at another rate.
pub(super) fn own_affair(index: &Index, id: FunctionId) -> Option<String> {
    let (key, of, name) = declared(index, law_of(index, id).filter(|spec| spec.is_preset)?)?;
    let CrateInfo { name: krate, .. } = index.crate_of(of);
    if index.module(index.function(id).module).krate != index.module(of).krate {
        return None;
    }
    let modules = std::iter::successors(Some(index.module(of)), |at| at.parent.map(|parent| index.module(parent)));
    let mut parts: Vec<&str> = modules.filter(|at| at.parent.is_some()).map(|at| at.name.as_str()).collect();
    parts.push("crate");
    parts.reverse();
    let path = format!("{}::{name}", parts.join("::"));
    Some(format!(
        "`{krate}` itself has this law, and its preset only tells how other crates run its filters; a `[[filter]]` of its own with \
         `{key} = \"{path}\"` has it judged"
    ))
}

/// What an entry for these filters names: its key, and where that is declared by which name.
fn declared<'a>(index: &'a Index, spec: &FilterSpec) -> Option<(&'static str, ModuleId, &'a str)> {
    match spec.subject {
        Subject::Trait(TraitName::Local(of)) => {
            let def = index.trait_def(of);
            Some(("trait", def.module, &def.name))
        }
        Subject::Type(of) => {
            let def = index.type_def(of);
            Some(("type", def.module, &def.name))
        }
        _ => None,
    }
}

fn is_constructor(index: &Index, id: FunctionId) -> bool {
    let def = index.function(id);
    def.function.receiver.is_none()
        && (matches!(def.name.as_str(), "new" | "default" | "init" | "build" | "create")
            || ["new_", "with_", "from_", "init_"].iter().any(|prefix| def.name.starts_with(prefix)))
}

/// Attributes of functions that a framework calls once per cycle.
const CYCLE_ATTRIBUTES: &[&str] = &["interrupt", "exception", "handler"];

/// Methods of traits that a framework calls once per cycle.
const CYCLE_METHODS: &[(&str, &str)] =
    &[("RealtimeFunctionality", "cycle"), ("CuTask", "process"), ("Future", "poll"), ("Iterator", "next")];
