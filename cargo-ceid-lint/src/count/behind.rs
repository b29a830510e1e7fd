//! Filters inside a trait object or type parameter: each type that may be behind it has a verdict of its own.

use super::analyse::{Context, FunctionFacts};
use super::cycles::Instance;
use super::decide::Decision;
use super::search::Search;
use crate::index::Ty;

impl Context<'_> {
    /// The verdict on a filter inside a trait object or a type parameter is that of each type that may be behind it: the one that
    /// says most against it counts.
    pub(super) fn decide_behind(
        &self,
        facts: &FunctionFacts<'_>,
        instance: &Instance,
        search: &Search<'_>,
        decide: impl Fn(&Search<'_>) -> Decision,
    ) -> Decision {
        if search.behind.len() < 2 {
            return decide(search);
        }
        let of_type = |ty: &Ty| {
            let mut search = self.search(facts, instance);
            search.only_behind(ty);
            let decision = decide(&search);
            self.effort.add(facts.graph.nodes.len() / 8 + search.take_states());
            decision
        };
        let decisions = search.behind.iter().map(of_type);
        // A type of which nothing is updated here has its updates elsewhere.
        let updated = decisions.filter(|decision| decision.counts != [0] || decision.cause.is_some());
        updated.max_by_key(|decision| decision.verdict.gravity()).unwrap_or_else(|| decide(search))
    }
}
