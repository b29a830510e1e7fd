//! Calls that are one update each, whatever type is behind the trait that they are made by.

use super::Search;
use crate::count::dispatched;
use crate::flow::{Effect, NodeId};

impl Search<'_> {
    /// Whether something unseen is one update, whatever type is behind a trait there, or none.
    pub(super) fn is_told(&self, id: NodeId) -> bool {
        let Self { program, graph, summaries, aliases, law, .. } = self;
        let told = self.told.get_or_init(|| {
            let is_marked = |id: &NodeId| matches!(&graph.node(*id).effect, Effect::Unknown { cause, .. } if *cause == dispatched::too_many());
            let marked = graph.node_ids().filter(is_marked);
            let marked = marked.filter(|id| dispatched::is_one_update(program.index, graph, summaries, *id, *law));
            let handed = graph.loops.iter().flat_map(|info| &info.handed).copied();
            marked.chain(handed.filter(|id| summaries.leaves_alone(graph, aliases, *id, self.instance))).collect()
        });
        told.contains(&id)
    }
}
