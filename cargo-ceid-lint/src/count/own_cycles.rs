//! Updates that run in cycles of their own in a called function: `if request { self.home(); }` owes them nothing where it is not
//! called.

use super::called_place::CalledPlace;
use super::counts::Count;
use super::search::{Region, Search};
use crate::flow::{Effect, NodeId};

/// Whether a function updates the instance in nothing but such loops: its own, or those of what it calls.
pub(super) fn runs(search: &Search<'_>) -> bool {
    let updating = search.updating();
    !updating.is_empty() && updating.into_iter().all(|node| is_in_cycle(search, node) || is_in_callee(search, node))
}

/// Whether a region only calls functions that update the instance so.
pub(super) fn are_called(search: &Search<'_>, region: Region) -> bool {
    let is_inside = |node: &NodeId| region.holds(search.graph, search.graph.node(*node).in_loop);
    let mut updating = search.updating().into_iter().filter(is_inside).peekable();
    updating.peek().is_some() && updating.all(|node| is_in_callee(search, node))
}

/// Whether a node lies in a loop that goes round until something in it ends it.
fn is_in_cycle(search: &Search<'_>, node: NodeId) -> bool {
    search.graph.loops_around(node).any(|id| search.graph.loop_info(id).may_be_cycle() && !search.covers(id))
}

/// Whether a node calls a function that updates the instance in nothing but such loops.
fn is_in_callee(search: &Search<'_>, node: NodeId) -> bool {
    let Effect::Call(site) = &search.graph.node(node).effect else { return false };
    let called = search.aliases.called_places(site, search.summaries);
    let is_updated = |called: &&CalledPlace| {
        called.law == search.law
            && called.roots().iter().any(|root| root.overlaps(search.instance))
            && called.outcomes(search.summaries).iter().any(|outcome| outcome.count != Count::Zero)
    };
    let mut updated = called.iter().filter(is_updated).peekable();
    updated.peek().is_some() && updated.all(|called| called.runs_own_cycles(search.summaries))
}
