//! Calls that are one update each, whatever type is behind the trait that they are made by.

use super::Search;
use crate::count::dispatched;
use crate::flow::{Effect, NodeId};

impl Search<'_> {
    /// Whether something unseen is one update, whatever type is behind a trait there.
    pub(super) fn is_one_update(&self, id: NodeId) -> bool {
        let Self { program, graph, summaries, law, .. } = self;
        let one_updates = self.one_updates.get_or_init(|| {
            let is_marked = |id: &NodeId| matches!(&graph.node(*id).effect, Effect::Unknown { cause, .. } if *cause == dispatched::too_many());
            let marked = graph.node_ids().filter(is_marked);
            marked.filter(|id| dispatched::is_one_update(program.index, graph, summaries, *id, *law)).collect()
        });
        one_updates.contains(&id)
    }
}
