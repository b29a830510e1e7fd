//! Filters inside a trait object or type parameter: each type that may be behind it has a verdict of its own.

use super::analyse::{Context, FunctionFacts};
use super::cycles::Instance;
use super::decide::Decision;
use super::instances::{follow, known_steps};
use super::search::Search;
use super::verdict::Verdict;
use crate::flow::{Cause, ControlFlowGraph, Place, Projection};
use crate::index::{Index, Ty};

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

/// The types that may be behind a trait object or a type parameter on the way to a place, as far as they have such a place: where
/// it is the trait object itself, those that are filters. What lies inside a filter is its own law's business.
pub(super) fn types_behind(index: &Index, graph: &ControlFlowGraph, place: &Place) -> Vec<Ty> {
    let is_filter = |ty: &Ty| index.filter_spec(ty).is_some();
    // What the bounds make a filter is one whatever lies behind them.
    let Some((ty, at)) = known_steps(index, graph, place).filter(|(ty, _)| !is_filter(ty)) else { return Vec::new() };
    let rest = &place.steps[at..];
    let has_place =
        |owner: &&Ty| if rest.is_empty() { is_filter(owner) } else { part_of(index, owner, rest).is_some() };
    index.types_behind(&ty).iter().filter(has_place).cloned().collect()
}

/// The type that all of these steps lead to in a type, or in one of those that may stand for a parameter of it. What is made of itself,
/// as `Chain<Chain<Pid>>`, is not gone into: its code is that of the outer one.
pub(super) fn part_of(index: &Index, owner: &Ty, steps: &[Projection]) -> Option<Ty> {
    part_within(index, owner, steps, &mut Vec::new())
}

fn part_within(index: &Index, owner: &Ty, steps: &[Projection], around: &mut Vec<Ty>) -> Option<Ty> {
    let (open, at) = follow(index, owner.clone(), steps)?;
    if at == steps.len() || at == 0 || around.contains(owner) {
        return Some(open).filter(|_| at == steps.len());
    }
    around.push(owner.clone());
    let is_other = |inside: &&Ty| !around.contains(inside);
    let inside: Vec<Ty> = index.types_behind(&open).iter().filter(is_other).cloned().collect();
    let part = inside.iter().find_map(|inside| part_within(index, inside, &steps[at..], around));
    around.pop();
    part
}
