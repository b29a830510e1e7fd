//! Filters that may not be there: `if let Some(filter) = &mut self.filter { filter.reset(); }`. On a way without one, nothing is owed,
//! whatever else decided that no update can be reached.

use super::{Region, Search};
use crate::count::gates::Gates;
use crate::flow::{Effect, NodeId};

/// Methods of an `Option` that leave it to be there or not. What else is called may have none to give for another reason.
const ACCESSORS: &[&str] =
    &["as_mut", "as_ref", "as_deref", "as_deref_mut", "is_some", "is_none", "map", "map_or", "map_or_else", "and_then"];

impl Search<'_> {
    /// Whether the instance is not there behind an edge of a branch.
    pub(super) fn lacks_filter(&self, region: Region, branch: NodeId, edge: usize) -> bool {
        let Effect::Branch(test) = &self.graph.node(branch).effect else { return false };
        let absent = match test.about.heads.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
            ["+"] => 1,
            ["-"] => 0,
            _ => return false,
        };
        edge == absent && self.asks_for_filter(region, branch)
    }

    /// Whether a branch asks for nothing but whether the instance is there.
    pub(super) fn asks_for_filter(&self, region: Region, branch: NodeId) -> bool {
        let Effect::Branch(test) = &self.graph.node(branch).effect else { return false };
        let is_accessor = |name: &String| ACCESSORS.contains(&name.as_str());
        if !test.about.is_presence || !test.about.names.iter().all(is_accessor) {
            return false;
        }
        if let Some(known) = self.presence.borrow().get(&branch) {
            return *known;
        }
        let asks = Gates::new(self, region).asks_own_presence(test);
        self.presence.borrow_mut().insert(branch, asks);
        asks
    }
}
