//! Loops that only wait until a filter can be updated: `loop { if port.is_busy() { continue } filter.update(x); break }`.

use std::collections::BTreeSet;

use super::aliases::Aliases;
use super::search::{Region, Search};
use super::summary::Summaries;
use crate::flow::{ControlFlowGraph, Effect, LoopId, NodeId, Place, Rounds};

/// The loops that end with the one update in them, and drive nothing and do nothing with the instance before: they wait until it can
/// be updated.
pub(super) fn find(
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    summaries: &Summaries,
    search: &Search<'_>,
    nodes: &BTreeSet<NodeId>,
) -> BTreeSet<LoopId> {
    let touches = |place: &Place| {
        let is_it = |root: &Place| root.steps.len() >= search.instance.steps.len() && root.overlaps(search.instance);
        aliases.shared_roots(place).iter().any(is_it)
    };
    let works = |node: NodeId| match &graph.node(node).effect {
        Effect::Update(_) => true,
        Effect::Use { place } => touches(place),
        Effect::Call(site) => {
            summaries.updates(site).next().is_some()
                || site.args.iter().filter_map(|arg| arg.place.as_ref()).any(touches)
        }
        _ => false,
    };
    let is_wait = |id: &LoopId| {
        let info = graph.loop_info(*id);
        let inside = || graph.node_ids().filter(|node| graph.is_within(graph.node(*node).in_loop, *id));
        let from = |node: NodeId| search.reached_from(Region::Loop(*id), node, |_, _| true);
        let goes_on =
            |reached: &[bool]| inside().any(|at| reached[at.0 as usize] && graph.node(at).next.contains(&info.head));
        let ends_with = |node: NodeId| {
            let reached = from(node);
            !goes_on(&reached) && !nodes.iter().any(|other| *other != node && reached[other.0 as usize])
        };
        // A loop that never goes round is a choice.
        let rounds_of = |node: NodeId| graph.loops_around(node).find(|around| graph.loop_info(*around).goes_round);
        let is_once = |node: NodeId| rounds_of(node) == Some(*id) && ends_with(node);
        info.rounds == Rounds::Unbounded
            && info.goes_round
            && !info.is_unseen()
            && inside().filter(|node| nodes.contains(node)).all(is_once)
            && !inside().any(|node| works(node) && goes_on(&from(node)))
    };
    let around: BTreeSet<LoopId> = nodes.iter().flat_map(|node| graph.loops_around(*node)).collect();
    around.into_iter().filter(is_wait).collect()
}
