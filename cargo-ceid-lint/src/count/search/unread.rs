//! Ways that a macro takes which could not be read: whether there are such ways is not known.

use super::EndKind;
use super::run::Run;
use crate::count::counts::Count;
use crate::flow::Effect;

impl Run<'_, '_> {
    /// Nothing is said of a filter that only such a way leaves without its update.
    pub(super) fn doubt_unread(&mut self) {
        let graph = self.search.graph;
        for number in 0..self.exploration.ends.len() {
            let end = &self.exploration.ends[number];
            let is_skipped = end.kind == EndKind::Completes && end.state.count == Count::Zero && !end.state.reset;
            let Some(at) = end.state.skipped_at.filter(|_| is_skipped) else { continue };
            if let Effect::Branch(test) = &graph.node(at).effect
                && let Some(cause) = &test.about.unread
            {
                self.exploration.ends[number].state.unknown = Some(self.cause(cause));
            }
        }
    }
}
