//! What an iteration can reach.

use super::Gates;
use crate::count::search::Region;
use crate::flow::{Effect, NodeId};

impl Gates<'_, '_> {
    /// The node at which an iteration begins.
    pub(super) fn start(&self) -> NodeId {
        match self.region {
            Region::Function => NodeId(0),
            Region::Loop(own) => self.search.graph.loop_info(own).head,
        }
    }

    /// The nodes that an iteration can reach; `follows` says which edges it may take.
    pub(super) fn reached(&self, follows: impl Fn(NodeId, usize) -> bool) -> Vec<bool> {
        self.reached_from(self.start(), follows)
    }

    pub(super) fn reached_from(&self, from: NodeId, follows: impl Fn(NodeId, usize) -> bool) -> Vec<bool> {
        self.search.reached_from(self.region, from, follows)
    }

    /// Whether an iteration can come to its end from a node by these edges.
    pub(super) fn completes(&self, from: NodeId, follows: impl Fn(NodeId, usize) -> bool) -> bool {
        let graph = self.search.graph;
        let start = self.start();
        let reached = self.reached_from(from, &follows);
        self.nodes().filter(|id| reached[id.0 as usize]).any(|id| match self.region {
            Region::Function => matches!(graph.node(id).effect, Effect::Return(_)),
            Region::Loop(_) => {
                let edges = graph.node(id).next.iter().enumerate();
                edges.filter(|(_, next)| **next == start).any(|(edge, _)| follows(id, edge))
            }
        })
    }

    /// Whether a node belongs to another function that is read where it is called.
    pub(super) fn is_read_in_place(&self, at: NodeId) -> bool {
        let graph = self.search.graph;
        let body = self.search.program.index.function(graph.function).function.body.as_ref();
        body.is_some_and(|body| !body.expr(body.root).span.contains(graph.node(at).span))
    }
}
