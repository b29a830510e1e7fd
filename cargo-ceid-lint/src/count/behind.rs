//! Filters inside a trait object or type parameter: each type that may be behind it has a verdict of its own.

use super::analyse::{Context, FunctionFacts};
use super::cycles::Instance;
use super::decide::Decision;
use super::instances::known_steps;
use super::search::Search;
use super::verdict::Verdict;
use crate::flow::{Cause, Projection};
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
        let decisions = search.behind.iter().map(|ty| (ty, of_type(ty)));
        // A type of which nothing is updated here has its updates elsewhere.
        let (idle, updated): (Vec<_>, Vec<_>) =
            decisions.partition(|(_, decision)| decision.counts == [0] && decision.cause.is_none());
        let gravest = updated.into_iter().map(|(_, decision)| decision).max_by_key(|found| found.verdict.gravity());
        let Some(decision) = gravest else { return decide(search) };
        let is_proof = matches!(
            decision.verdict,
            Verdict::Once | Verdict::Guarded | Verdict::OnceOrReset | Verdict::PerSample | Verdict::Gated
        );
        match idle.iter().find_map(|(ty, _)| self.never_updated_in(facts, instance, ty)).filter(|_| is_proof) {
            Some(name) => {
                let cause = format!("`{name}`, which may be behind the trait, has one as well that nothing updates");
                Decision { primary: decision.primary, ..Decision::unproved(Cause::Limit(cause)) }
            }
            None => decision,
        }
    }

    /// The name of a type that may be behind the trait, if no code updates the field of it that would be the instance.
    fn never_updated_in(&self, facts: &FunctionFacts<'_>, instance: &Instance, ty: &Ty) -> Option<&str> {
        let index = self.program.index;
        let (_, at) = known_steps(index, facts.graph, &instance.place)?;
        let (Ty::Adt(id, _), [Projection::Field(name)]) = (ty, instance.place.steps.get(at..)?) else { return None };
        let field = (index.declares_fields(*id), vec![name.to_string()]);
        (!self.fields.has(&field) && !self.anywhere.has(&field)).then(|| index.type_def(*id).name.as_str())
    }
}
