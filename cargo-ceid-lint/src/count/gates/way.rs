//! Ways through a cycle that do not update the filter.

use crate::count::search::{End, Exploration};
use crate::flow::NodeId;

/// A way that does not update: its nodes, and the one at which that was decided.
pub(super) struct Way {
    pub(super) nodes: Vec<NodeId>,
    pub(super) at: NodeId,
    /// The node at which the search leaves the update: another one where what is asked there was decided before.
    pub(super) left_at: NodeId,
}

impl Way {
    /// The way to an end that was decided at a node.
    pub(super) fn to(exploration: &Exploration, end: &End, at: NodeId) -> Self {
        let nodes = exploration.path(end.at).iter().map(|at| exploration.states[*at].node).collect();
        Self { nodes, at, left_at: at }
    }

    /// The node that follows another one on the way.
    pub(super) fn after(&self, at: NodeId) -> Option<NodeId> {
        let number = self.nodes.iter().position(|id| *id == at)?;
        self.nodes.get(number + 1).copied()
    }

    /// Its nodes but for the last one, each with the one that follows it.
    pub(super) fn steps(&self) -> impl Iterator<Item = (&NodeId, &NodeId)> {
        self.nodes.iter().zip(self.nodes.iter().skip(1))
    }
}
