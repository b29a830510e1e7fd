//! From where in an iteration an update can still be reached.

use super::{Region, Search};
use crate::flow::{ControlFlowGraph, Effect, LoopId, NodeId, Place};

impl Region {
    /// Whether what stands in a loop, if it is in one, stands in the region.
    pub(in crate::count) fn holds(self, graph: &ControlFlowGraph, in_loop: Option<LoopId>) -> bool {
        match self {
            Self::Function => true,
            Self::Loop(own) => graph.is_within(in_loop, own),
        }
    }
}

impl Search<'_> {
    /// Whether a branch decides that a node is reached.
    pub(in crate::count) fn decides(&self, branch: NodeId, node: NodeId) -> bool {
        self.dependence.of_node(node).contains(&branch.0)
    }

    /// The nodes that a node follows.
    pub(in crate::count) fn before(&self, node: NodeId) -> &[NodeId] {
        self.dependence.before(node)
    }

    /// Whether a place is there before and after an iteration.
    pub(in crate::count) fn outlives(&self, region: Region, place: &Place) -> bool {
        let graph = self.graph;
        match (region, place.base_var()) {
            (Region::Loop(own), Some(var)) => !graph.is_within(graph.var(var).in_loop, own),
            (Region::Function, Some(var)) => graph.var(var).param.is_some(),
            (_, None) => true,
        }
    }

    /// The nodes from which an update can be reached without leaving the iteration.
    pub(in crate::count) fn reach(&self, region: Region) -> Vec<bool> {
        self.reach_to(region, self.updating().into_iter().collect())
    }

    /// The same for other nodes than updates.
    pub(super) fn reach_to(&self, region: Region, nodes: Vec<NodeId>) -> Vec<bool> {
        let graph = self.graph;
        let is_own_head = |id: NodeId| matches!(region, Region::Loop(own) if id == graph.loop_info(own).head);
        let is_inside =
            |id: &NodeId| !matches!(region, Region::Loop(own) if !graph.is_within(graph.node(*id).in_loop, own));
        // The next round of a loop over the elements is another element's: for this one, what is behind the loop follows.
        let others = |head: NodeId| match &graph.node(head).effect {
            Effect::LoopHead(id) if self.covers(*id) && !is_own_head(head) => Some(*id),
            _ => None,
        };
        let is_round = |id: NodeId, head: NodeId| {
            others(head).is_some_and(|covered| graph.is_within(graph.node(id).in_loop, covered))
        };
        let mut reach = vec![false; graph.nodes.len()];
        let mut open = nodes;
        while let Some(id) = open.pop() {
            if std::mem::replace(&mut reach[id.0 as usize], true) {
                continue;
            }
            for before in self.dependence.before(id) {
                if is_inside(before) && !is_own_head(id) && !is_round(*before, id) {
                    open.push(*before);
                }
                if graph.node(*before).next.get(1) == Some(&id) {
                    let rounds = self.dependence.before(*before).iter().filter(|round| is_round(**round, *before));
                    open.extend(rounds.copied().filter(is_inside));
                }
            }
        }
        reach
    }

    /// The nodes that an iteration can reach from one, which is among them; `follows` says which edges it may take.
    pub(in crate::count) fn reached_from(
        &self,
        region: Region,
        from: NodeId,
        follows: impl Fn(NodeId, usize) -> bool,
    ) -> Vec<bool> {
        let graph = self.graph;
        let is_inside = |to: NodeId| match region {
            Region::Function => true,
            Region::Loop(id) => to != graph.loop_info(id).head && graph.is_within(graph.node(to).in_loop, id),
        };
        let mut reached = vec![false; graph.nodes.len()];
        let mut open = vec![from];
        while let Some(id) = open.pop() {
            if std::mem::replace(&mut reached[id.0 as usize], true) {
                continue;
            }
            for (edge, next) in graph.node(id).next.iter().enumerate() {
                if is_inside(*next) && follows(id, edge) {
                    open.push(*next);
                }
            }
        }
        reached
    }
}
