//! Which of the cycles that update something in the same scope owes a filter its update.

use super::analyse::{Context, CycleId, FunctionFacts};
use super::instances::{Leaf, is_in_given, is_resource};
use crate::flow::{ControlFlowGraph, LoopId, NodeId, Place, Rounds};
use crate::index::Index;

impl Context<'_> {
    /// Whether a filter lies in what a loop around the cycle makes anew, and may be there or not, and the cycle asks nothing of it: values
    /// that are put into a collection there are what the cycle found out.
    pub(super) fn is_only_filled_in(&self, facts: &FunctionFacts<'_>, place: &Place, leaf: &Leaf, id: CycleId) -> bool {
        let graph = facts.graph;
        let CycleId::Loop(id) = id else { return false };
        let is_made_anew = place.base_var().is_some_and(|var| graph.var(var).in_loop.is_some());
        let is_used_at =
            |node: NodeId| graph.is_within(graph.node(node).in_loop, id) && self.node_uses(facts, node, place);
        leaf.is_uncertain
            && is_made_anew
            && !self.is_beside_updated(facts, place, leaf.is_shared)
            && !graph.node_ids().any(is_used_at)
    }

    /// The cycle that owes an update to what none updates: one that uses it and updates a sibling, one that updates a sibling for ever,
    /// the one that uses it, and at last one that updates a sibling for some time. A thread that does not have it owes it nothing.
    pub(super) fn owing(
        &self,
        facts: &FunctionFacts<'_>,
        place: &Place,
        siblings: &[CycleId],
        using: Option<LoopId>,
    ) -> Option<CycleId> {
        let graph = facts.graph;
        let uses_it = |id: &&CycleId| match **id {
            CycleId::Loop(id) => {
                let mut inside = graph.node_ids().filter(|node| graph.is_within(graph.node(*node).in_loop, id));
                inside.any(|node| self.node_uses(facts, node, place))
            }
            CycleId::Function => false,
        };
        let is_here = |id: &&CycleId| match **id {
            CycleId::Loop(id) => !runs_elsewhere(graph, id) || is_declared_elsewhere(graph, place),
            CycleId::Function => true,
        };
        let goes_on = |id: &&CycleId| match **id {
            CycleId::Loop(id) => graph.loop_info(id).rounds == Rounds::Unbounded,
            CycleId::Function => true,
        };
        let mut here = siblings.iter().filter(is_here);
        let first = siblings.iter().find(uses_it).or_else(|| here.clone().find(goes_on)).copied();
        first.or(using.map(CycleId::Loop)).or_else(|| here.next().copied())
    }

    /// Whether a cycle updates something in the same scope: a local of the function, or a field of the same value.
    pub(super) fn is_sibling(&self, facts: &FunctionFacts<'_>, place: &Place, id: CycleId) -> bool {
        let graph = facts.graph;
        let is_local = |place: &Place| {
            place.base_var().is_some_and(|var| {
                let is_given = || matches!(id, CycleId::Loop(_)) && is_in_given(self.program.index, graph, place);
                graph.var(var).param.is_none() || place.steps.is_empty() || is_given()
            })
        };
        // What a task locks for another part of it is not in scope as a whole.
        let resource = resource_around(self.program.index, graph, place);
        let shares_it = |other: &Place| resource.as_ref().is_none_or(|all| other.steps.starts_with(&all.steps));
        facts.updated.iter().any(|instance| {
            let belongs = match id {
                CycleId::Loop(id) => instance.loops.contains(&id),
                CycleId::Function => instance.function,
            };
            belongs
                && ((instance.place.base == place.base && instance.place != *place && shares_it(&instance.place))
                    || (is_local(&instance.place) && is_local(place)))
        })
    }
}

/// The resource of several tasks of which a place is a part.
fn resource_around(index: &Index, graph: &ControlFlowGraph, place: &Place) -> Option<Place> {
    let mut owners = (0..place.steps.len()).map(|at| place.up_to(at));
    owners.find(|owner| is_resource(index, graph, owner))
}

/// Whether a loop is one of a thread or task that begins in the function.
fn runs_elsewhere(graph: &ControlFlowGraph, id: LoopId) -> bool {
    let outermost = graph.loops_around(graph.loop_info(id).head).last().unwrap_or(id);
    let head = graph.loop_info(outermost).head;
    graph.elsewhere.keys().any(|before| graph.node(*before).next.contains(&head))
}

/// Whether a place is one of a variable of such a thread or task.
fn is_declared_elsewhere(graph: &ControlFlowGraph, place: &Place) -> bool {
    let var = place.base_var().map(|var| graph.var(var));
    var.is_some_and(|info| info.param.is_none() && graph.elsewhere.contains_key(&info.declared))
}
