//! Updates that what is shipped does not have: in `debug_assert!`, in the arguments of a log macro, under
//! `cfg(debug_assertions)`. They count for nothing, and are remembered for the rule that names them.

use std::collections::BTreeSet;

use super::aliases::Aliases;
use super::analyse::CycleId;
use super::counts::Count;
use super::given::place_of;
use super::summary::Summaries;
use crate::flow::{ControlFlowGraph, Effect, LoopId, Node, NodeId, Place, Rounds};
use crate::source::Span;

/// What keeps an update from what is shipped.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct DebugOnly {
    /// The update.
    pub(super) span: Span,
    /// As the source spells it: `debug_assert!`, `#[cfg(debug_assertions)]`.
    pub(super) by: String,
}

/// An update that only a debug build runs, in a function or in what it calls.
#[derive(Clone, Debug)]
pub(super) struct DebugUpdate {
    /// Where it happens in the function; for a callee's update, the call.
    pub(super) node: NodeId,
    /// The filter.
    pub(super) place: Place,
    /// The half of its law.
    pub(super) law: usize,
    /// What keeps it back.
    pub(super) why: DebugOnly,
}

/// The updates of a function that only a debug build runs.
pub(super) fn updates(graph: &ControlFlowGraph, aliases: &Aliases, summaries: &Summaries) -> Vec<DebugUpdate> {
    let mut found = Vec::new();
    // A closure may be run both by what only a debug build has and by what stands in its place.
    let shipped: BTreeSet<Span> = graph
        .nodes
        .iter()
        .filter(|node| node.debug_only.is_none() && matches!(node.effect, Effect::Update(_) | Effect::Call(_)))
        .map(|node| node.span)
        .collect();
    let is_shipped = |node: &Node| node.debug_only.is_some() && shipped.contains(&node.span);
    for id in graph.node_ids().filter(|id| !is_shipped(graph.node(*id))) {
        let node = graph.node(id);
        let own = node.debug_only.and_then(|branch| match &graph.node(branch).effect {
            Effect::Branch(test) => Some(DebugOnly { span: node.span, by: test.text.clone() }),
            _ => None,
        });
        let mut add = |place: &Place, law: usize, why: &DebugOnly| {
            let roots = aliases.roots(place).into_iter();
            found.extend(roots.map(|place| DebugUpdate { node: id, place, law, why: why.clone() }));
        };
        match (&node.effect, &own) {
            (Effect::Update(update), Some(why)) => add(&update.place, update.law, why),
            (Effect::Call(site), _) => {
                for summary in site.targets.iter().filter_map(|target| summaries.get(*target)) {
                    for ((given, law), why) in &summary.debug_only {
                        if let Some(place) = place_of(given, site) {
                            add(&place, *law, why);
                        }
                    }
                    let Some(why) = &own else { continue };
                    for (law, given, outcomes) in summary.outcomes_by_half() {
                        let updates = outcomes.iter().any(|outcome| outcome.count != Count::Zero);
                        // A law that hands on to another one of the same filter is one update.
                        if updates && let Some(place) = place_of(given, site) {
                            add(&place, law, why);
                        }
                    }
                }
            }
            _ => {}
        }
    }
    found
}

/// Whether an update belongs to the callers of its function, not to a loop of the function's own.
pub(super) fn is_callers(graph: &ControlFlowGraph, id: NodeId) -> bool {
    graph.loops_around(id).all(|own| matches!(graph.loop_info(own).rounds, Rounds::Constant(_)))
}

/// Whether a debug build runs an update besides those that are shipped: one of these stands on each way to it, or on each way on from
/// it, through an iteration.
pub(super) fn is_besides(graph: &ControlFlowGraph, at: NodeId, shipped: &BTreeSet<NodeId>, cycle: CycleId) -> bool {
    let (start, head) = match cycle {
        CycleId::Loop(id) => (graph.node(graph.loop_info(id).head).next.first().copied(), Some(id)),
        CycleId::Function => (Some(NodeId(0)), None),
    };
    let is_shipped = |id: NodeId| id != at && shipped.contains(&id);
    let before = reached_in_debug(graph, start, head, &is_shipped);
    let behind = reached_in_debug(graph, graph.node(at).next.first().copied(), head, &is_shipped);
    let ends = |id: &NodeId| match head {
        Some(id_of) => !graph.is_within(graph.node(*id).in_loop, id_of) || *id == graph.loop_info(id_of).head,
        None => matches!(graph.node(*id).effect, Effect::Return(_)),
    };
    !before.contains(&at) || (!behind.iter().any(ends) && behind.iter().any(|id| is_shipped(*id)))
}

/// The nodes that a debug build can come to in an iteration from one of its nodes, without going on from some.
fn reached_in_debug(
    graph: &ControlFlowGraph,
    from: Option<NodeId>,
    cycle: Option<LoopId>,
    stops: &dyn Fn(NodeId) -> bool,
) -> BTreeSet<NodeId> {
    let mut reached = BTreeSet::new();
    let mut open: Vec<NodeId> = from.into_iter().collect();
    while let Some(id) = open.pop() {
        let is_out = cycle
            .is_some_and(|cycle| id == graph.loop_info(cycle).head || !graph.is_within(graph.node(id).in_loop, cycle));
        if !reached.insert(id) || is_out || stops(id) {
            continue;
        }
        let node = graph.node(id);
        let is_debug = matches!(&node.effect, Effect::Branch(test) if test.about.is_debug);
        open.extend(node.next.iter().take(if is_debug { 1 } else { usize::MAX }));
    }
    reached
}
