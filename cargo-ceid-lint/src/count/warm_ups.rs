//! Loops that run a filter in behind its reset: `if lost { f.reset(); for _ in 0..256 { f.update(x); } }`. Whether they
//! belong to the reset, which leaves a state that is fit for use, only a person knows.

use super::counts::Count;
use super::search::{EndKind, Exploration, Region, Search};
use crate::flow::{Effect, LoopId, NodeId, Rounds};

/// Whether all that an iteration updates more than once is such a loop: each way to it resets the filter and has not updated it, and
/// no way updates twice besides.
pub(super) fn is_run_in(search: &Search<'_>, region: Region, exploration: &Exploration) -> bool {
    let graph = search.graph;
    let updating = search.updating();
    let own = match region {
        Region::Loop(id) => Some(id),
        Region::Function => None,
    };
    let is_plain = |node: NodeId| match &graph.node(node).effect {
        Effect::Update(update) => !update.run_by.is_guard() && update.attempt.is_none(),
        _ => false,
    };
    if !updating.iter().all(|node| is_plain(*node)) {
        return false;
    }
    let (besides, within): (Vec<NodeId>, Vec<NodeId>) =
        updating.into_iter().partition(|node| graph.node(*node).in_loop == own);
    let Some(id) = within.first().and_then(|node| graph.node(*node).in_loop) else { return false };
    let is_counted = matches!(graph.loop_info(id).rounds, Rounds::Constant(rounds) if rounds > 1);
    if !is_counted || search.binds(id) || within.iter().any(|node| graph.node(*node).in_loop != Some(id)) {
        return false;
    }
    let is_last = |node: NodeId| {
        let reached = search.reached_from(region, node, |_, _| true);
        besides.iter().all(|other| *other == node || !reached[other.0 as usize])
    };
    // What begins anew in each iteration gets all its updates there.
    let mut completing = exploration.ends.iter().filter(|end| end.kind == EndKind::Completes);
    let is_rare = completing.any(|end| !end.state.reset);
    is_rare && enters_behind_reset(search, exploration, id) && besides.iter().all(|node| is_last(*node))
}

fn enters_behind_reset(search: &Search<'_>, exploration: &Exploration, id: LoopId) -> bool {
    let enters = |node: NodeId| matches!(search.graph.node(node).effect, Effect::LoopEnter(entered) if entered == id);
    let mut entering = exploration.states.iter().filter(|state| enters(state.node)).peekable();
    entering.peek().is_some() && entering.all(|state| state.reset && state.count == Count::Zero)
}
