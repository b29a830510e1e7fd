//! Guards that are not alive to the end of their cycle.

use std::collections::{BTreeMap, BTreeSet};

use super::analyse::{Context, CycleId, FunctionFacts, filters_at};
use super::analysis::{Analysis, GuardDefect};
use super::functions::{FunctionKind, is_passed};
use super::remarks::note;
use super::summary::Summaries;
use super::verdict::{Pair, Verdict};
use crate::flow::{ControlFlowGraph, Effect, GuardInfo, LoopId, Node, NodeId, Place, Program, Rounds};
use crate::index::{FunctionId, Index, Owner};
use crate::source::Span;

/// Finds the defects of a function's guards, and adds their rules to the pairs of what they hold.
pub(super) fn add(
    context: &Context<'_>,
    facts: &FunctionFacts<'_>,
    pairs: &mut BTreeMap<CycleId, Vec<Pair>>,
    analysis: &mut Analysis,
) {
    let program = context.program;
    for (guard, defect) in defects(program, context.summaries, facts) {
        let of_places = |place| filters_at(program.index, facts.graph, &facts.aliases, place);
        let places: BTreeSet<Place> = guard.updates.iter().flat_map(of_places).collect();
        let name_of = |place| facts.graph.place_name(program.index, place);
        let held: Vec<String> = places.iter().map(name_of).chain(defect.names.iter().cloned()).collect();
        if defect.rule == "guard_outside_cycle" {
            leave_to_loop(context, facts, defect.cycle, &places, pairs);
        }
        let of_cycle = |id: CycleId| match id {
            CycleId::Loop(id) => Some(facts.graph.loop_info(id).keyword) == defect.cycle,
            CycleId::Function => defect.cycle.is_none(),
        };
        let own = pairs.iter_mut().filter(|(id, _)| of_cycle(**id)).flat_map(|(_, pairs)| pairs);
        for pair in own.filter(|pair| held.is_empty() || held.contains(&pair.name)) {
            note(pair, defect.rule);
        }
        analysis.guards.push(defect);
    }
}

/// The loop that runs while a guard from before it is alive owes what that holds, whether or not it uses it; the function around
/// the loop is no cycle that it could be guarded in.
fn leave_to_loop(
    context: &Context<'_>,
    facts: &FunctionFacts<'_>,
    keyword: Option<Span>,
    places: &BTreeSet<Place>,
    pairs: &mut BTreeMap<CycleId, Vec<Pair>>,
) {
    let mut loops = (0u32..).map(LoopId).zip(&facts.graph.loops);
    let Some((id, _)) = loops.find(|(_, info)| Some(info.keyword) == keyword) else { return };
    for place in places {
        let name = facts.graph.place_name(context.program.index, place);
        let is_known = |pair: &Pair| pair.name == name;
        if facts.kind == FunctionKind::Presumed
            && let Some(own) = pairs.get_mut(&CycleId::Function)
        {
            own.retain(|pair| pair.verdict != Verdict::Guarded || !is_known(pair));
        }
        if !pairs.get(&CycleId::Loop(id)).is_some_and(|own| own.iter().any(is_known)) {
            context.push_missed(facts, place, 0, CycleId::Loop(id), pairs);
        }
    }
    pairs.retain(|_, own| !own.is_empty());
}

fn defects<'f>(
    program: &Program<'_>,
    summaries: &Summaries,
    facts: &'f FunctionFacts<'_>,
) -> Vec<(&'f GuardInfo, GuardDefect)> {
    let mut found = Vec::new();
    let graph = facts.graph;
    let index = program.index;
    let def = index.function(graph.function);
    let info = index.crate_of(def.module);
    for (number, guard) in (0u32..).zip(&graph.guards).filter(|(_, guard)| !guard.is_destructor) {
        let cycle = guard.in_loop.map(|id| graph.loop_info(id).keyword);
        let mut defect = GuardDefect {
            package: info.package,
            target: info.target,
            rule: "",
            made: guard.span,
            span: guard.span,
            what: String::new(),
            names: guard.names.clone(),
            function: index.function_name(graph.function),
            cycle,
        };
        if let Some((span, how)) = &guard.forgotten {
            defect.rule = "forgotten_guard";
            defect.span = *span;
            defect.what.clone_from(how);
            found.push((guard, defect));
            continue;
        }
        if let Some((span, how)) = &guard.dropped {
            defect.rule = "guard_dropped_early";
            defect.span = *span;
            defect.what.clone_from(how);
            found.push((guard, defect));
            continue;
        }
        // The loop that runs while the guard is alive, and never ends before it.
        let start =
            graph.node_ids().find(|id| matches!(graph.node(*id).effect, Effect::GuardStart(own) if own.0 == number));
        let end = graph
            .node_ids()
            .filter(|id| matches!(graph.node(*id).effect, Effect::GuardEnd(own) if own.0 == number))
            .last();
        let Some(start) = start else { continue };
        let inside = (0u32..).map(LoopId).zip(&graph.loops).find(|(id, own)| {
            own.parent == guard.in_loop
                && (own.is_endless() || feeds_round_by_round(facts, guard, *id))
                && own.head > start
                && end.is_none_or(|end| own.head < end)
                && (!goes_on_behind(graph, guard, *id)
                    || feeds(facts, guard, *id)
                        && !is_used_around(facts, guard, *id)
                        && !feeds_item_of_round(facts, guard, *id))
                && (!is_passed(index, graph, summaries, *id) || asks_filters(index, graph, *id))
        });
        if let Some((_, own)) = inside {
            defect.rule = "guard_outside_cycle";
            defect.cycle = Some(own.keyword);
            found.push((guard, defect));
            continue;
        }
        // The guard of a function that the loop calls lives as long as that function, which is the cycle.
        let is_own = def.function.body.as_ref().is_none_or(|body| body.expr(body.root).span.contains(guard.span));
        if let Some(early) = ends_in_inner_block(graph, guard, end).filter(|_| is_own) {
            defect.rule = "guard_dropped_early";
            defect.span = early;
            defect.what = "the block it is bound in ends here".to_owned();
            found.push((guard, defect));
        }
    }
    found
}

/// Whether a loop that ends feeds a filter in each round that a guard from before it updates once: the guard of a clock that the
/// function itself has made, so that the rounds are its cycles. What a round chooses by its number is another filter in each.
fn feeds_round_by_round(facts: &FunctionFacts<'_>, guard: &GuardInfo, id: LoopId) -> bool {
    let graph = facts.graph;
    let is_own = |place: &Place| place.base_var().is_some_and(|var| graph.var(var).param.is_none());
    let is_once = matches!(graph.loop_info(id).rounds, Rounds::Constant(0 | 1));
    !is_once
        && guard.in_loop.is_none()
        && facts.kind != FunctionKind::Cycle
        && held_places(facts, guard).iter().all(is_own)
        && feeds(facts, guard, id)
}

/// Where the filters lie that a guard holds.
fn held_places(facts: &FunctionFacts<'_>, guard: &GuardInfo) -> Vec<Place> {
    guard
        .updates
        .iter()
        .flat_map(|place| facts.aliases.shared_roots(place).iter().cloned().collect::<Vec<_>>())
        .collect()
}

/// Whether a loop inside that in which a guard is made anew can be left for the rest of the guard's cycle.
fn goes_on_behind(graph: &ControlFlowGraph, guard: &GuardInfo, id: LoopId) -> bool {
    let is_inside = |node: NodeId| graph.is_within(graph.node(node).in_loop, id);
    let is_behind = |to: &NodeId| !is_inside(*to) && graph.node(*to).in_loop == guard.in_loop;
    let mut inside = graph.node_ids().filter(|node| is_inside(*node));
    guard.in_loop.is_some() && inside.any(|node| graph.node(node).next.iter().any(is_behind))
}

/// Whether the loop in which a guard is made feeds or reads what that holds outside of a loop in it: then its own rounds are the cycles.
fn is_used_around(facts: &FunctionFacts<'_>, guard: &GuardInfo, id: LoopId) -> bool {
    let graph = facts.graph;
    let is_held = held_by(facts, guard);
    let is_around = |node: &&Node| {
        guard.in_loop.is_some_and(|outer| graph.is_within(node.in_loop, outer))
            && !graph.is_within(node.in_loop, id)
            && !guard.span.contains(node.span)
            && !node.span.contains(guard.span)
    };
    let mut around = graph.node_ids().map(|node| graph.node(node)).filter(is_around);
    around.any(|node| match &node.effect {
        Effect::Call(site) => site.args.iter().filter_map(|arg| arg.place.as_ref()).any(&is_held),
        Effect::Write(write) => is_held(&write.place),
        Effect::Use { place } => is_held(place),
        _ => false,
    })
}

/// Whether a place lies in one that a guard holds.
fn held_by(facts: &FunctionFacts<'_>, guard: &GuardInfo) -> impl Fn(&Place) -> bool {
    let held = held_places(facts, guard);
    move |place| {
        let is_one = |root: &Place| root.steps.iter().all(|step| step.key().is_none());
        let lies_in = |root: &Place, own: &Place| root.lies_at(own);
        facts.aliases.shared_roots(place).iter().any(|root| is_one(root) && held.iter().any(|own| lies_in(root, own)))
    }
}

/// Whether something in a loop writes what a guard holds.
fn feeds(facts: &FunctionFacts<'_>, guard: &GuardInfo, id: LoopId) -> bool {
    let graph = facts.graph;
    let is_held = held_by(facts, guard);
    let mut inside = graph.node_ids().map(|node| graph.node(node)).filter(|node| graph.is_within(node.in_loop, id));
    inside.any(|node| match &node.effect {
        Effect::Call(site) => site.args.iter().any(|arg| !arg.is_shared && arg.place.as_ref().is_some_and(&is_held)),
        Effect::Write(write) => is_held(&write.place),
        _ => false,
    })
}

/// Whether a loop feeds what the loop around it, in which a guard is made, goes over: it tries again with the same sample.
fn feeds_item_of_round(facts: &FunctionFacts<'_>, guard: &GuardInfo, id: LoopId) -> bool {
    let graph = facts.graph;
    let Some(outer) = guard.in_loop.map(|outer| graph.loop_info(outer)) else { return false };
    let items = facts.aliases.derived_from(&outer.bound);
    let is_item = |place: &Place| place.base_var().is_some_and(|var| items.contains(var));
    let is_held = held_by(facts, guard);
    let inside = |id: &NodeId, within: LoopId| graph.is_within(graph.node(*id).in_loop, within);
    graph.node_ids().filter(|node| inside(node, id)).any(|node| match &graph.node(node).effect {
        Effect::Call(site) => {
            let is_fed = site.args.iter().any(|arg| !arg.is_shared && arg.place.as_ref().is_some_and(&is_held));
            is_fed && site.args.iter().flat_map(|arg| arg.place.iter().chain(&arg.from.places)).any(is_item)
        }
        Effect::Write(write) if is_held(&write.place) => {
            let computed = graph.changes.get(&node).into_iter().flat_map(|change| &change.computed.places);
            write.from.iter().chain(computed).any(is_item)
        }
        _ => false,
    })
}

/// Whether methods of filters are called within a loop.
fn asks_filters(index: &Index, graph: &ControlFlowGraph, id: LoopId) -> bool {
    let is_of_filter = |target: &FunctionId| match index.function(*target).owner {
        Owner::Impl(owner) => index.holds_filter(&index.impl_def(owner).self_ty),
        _ => false,
    };
    let mut inside = graph.node_ids().map(|node| graph.node(node)).filter(|node| graph.is_within(node.in_loop, id));
    inside.any(|node| matches!(&node.effect, Effect::Call(site) if site.targets.iter().any(is_of_filter)))
}

/// Where the block of a guard ends, if the cycle goes on behind it.
fn ends_in_inner_block(graph: &ControlFlowGraph, guard: &GuardInfo, end: Option<NodeId>) -> Option<Span> {
    let end = end?;
    let own = guard.in_loop?;
    let place = graph.node(end).span;
    let mut seen = BTreeSet::new();
    let mut open = vec![end];
    // The guard's end leads to the loop's head through nothing that does something.
    while let Some(at) = open.pop() {
        for next in graph.node(at).next.iter().copied() {
            let is_out = next == graph.loop_info(own).head || !graph.is_within(graph.node(next).in_loop, own);
            if is_out || !seen.insert(next) {
                continue;
            }
            let node = graph.node(next);
            let is_quiet = match &node.effect {
                Effect::Nothing | Effect::GuardEnd(_) | Effect::Set(_) => true,
                Effect::Update(update) => update.run_by.is_guard(),
                // What else ends with the block.
                _ => node.span == place,
            };
            if !is_quiet {
                return Some(place);
            }
            open.push(next);
        }
    }
    None
}
