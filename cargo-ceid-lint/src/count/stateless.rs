//! Filters without a state: a trait makes filters of them, and their law keeps nothing.

use super::analyse::{Context, FunctionFacts};
use super::given::GivenBase;
use super::instances::place_ty;
use crate::config::Receiver;
use crate::flow::Place;
use crate::index::{MethodOwner, Subject};

impl Context<'_> {
    /// Whether an entry for a trait makes a filter of what has no state, so that nothing is lost where its law does not run:
    /// `impl Effect for Gain`.
    pub(super) fn keeps_nothing(&self, facts: &FunctionFacts<'_>, place: &Place, law: usize) -> bool {
        let index = self.program.index;
        let Some(ty) = place_ty(index, facts.graph, place) else { return false };
        let Some(spec) = index.filter_spec(&ty) else { return false };
        let is_by_entry = spec.time_base.is_some() && spec.receiver == Receiver::Exclusive;
        if !is_by_entry || !matches!(spec.subject, Subject::Trait(_)) {
            return false;
        }
        let keeps = |owner: &MethodOwner| {
            let read = owner.function().filter(|id| index.function(*id).function.body.is_some());
            let Some(summary) = read.and_then(|id| self.summaries.get(id)) else { return true };
            let writes = summary.writes.iter().any(|written| written.base == GivenBase::Param(0));
            let mut changed = summary.halves.iter().flatten().filter(|(given, _)| given.base == GivenBase::Param(0));
            // What stands for the law itself says nothing of what it does.
            writes
                || changed.any(|(given, ways)| !given.steps.is_empty() || ways.iter().any(|way| way.unknown.is_some()))
        };
        let methods = spec.law.get(law).into_iter().flat_map(|group| &group.methods);
        let bodies: Vec<MethodOwner> = methods.flat_map(|name| index.methods(&ty, name)).collect();
        !bodies.is_empty() && !bodies.iter().any(keeps)
    }
}
