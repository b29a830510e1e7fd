//! States that the laws of other filters switch: what those make of them is not followed.

use super::Gates;
use crate::count::counts::Count;
use crate::count::search::{End, Mode};
use crate::flow::{CallSite, Cause, Effect, Relation, Test};

impl Gates<'_, '_> {
    /// Why it is not known whether a way that does not update pauses for a mode.
    pub(in crate::count) fn doubt(&self, end: &End) -> Option<Cause> {
        if end.state.count != Count::Zero || end.state.reset {
            return None;
        }
        let is_unknown = || self.search.has_unknown_modes() && self.nodes().any(|node| self.resets(node));
        let limit =
            || Cause::Limit("the cycle has too many paths to see whether a reset goes with each pause".to_owned());
        let by_other_name = || match &self.search.graph.node(end.state.skipped_at?).effect {
            Effect::Branch(test) => self.written_by_other_name(test),
            _ => None,
        };
        self.doubt_between()
            .or_else(|| self.hangs_on_law(end))
            .or_else(|| is_unknown().then(limit))
            .or_else(by_other_name)
    }

    /// Why what a condition asks may be written by another name in the iteration.
    pub(super) fn written_by_other_name(&self, test: &Test) -> Option<Cause> {
        let subject = test.subject.map(|id| &self.search.graph.subjects[id.0 as usize]);
        let asked = subject.into_iter().flat_map(|subject| subject.reads.clone());
        let mut places = self.behind(test).places.into_iter().chain(test.about.reads.iter().cloned()).chain(asked);
        places.find_map(|place| self.search.may_be_written_in(self.region, &place))
    }

    /// The law of another filter switches the state, and the filter is reset in each pause but for what that does:
    /// `profile.update(t); if profile.phase == Phase::Heat { pid.update(t); }`
    fn hangs_on_law(&self, end: &End) -> Option<Cause> {
        let graph = self.search.graph;
        let Effect::Branch(test) = &graph.node(end.state.skipped_at?).effect else { return None };
        let id = test.subject?;
        let writers = self.search.writers_of(id);
        let mut laws = writers.iter().filter_map(|node| match &graph.node(*node).effect {
            Effect::Call(site) if site.law_of.is_some() && !self.is_law_of_owner(site) => Some(site),
            _ => None,
        });
        let law = laws.next()?;
        let updating = self.updating(id)?;
        let mode = Mode { trusts_laws: true, ..Mode::new(id, updating) };
        let is_mode = self.nodes().any(|node| self.resets(node))
            && !self.pauses_for_good(id, updating)
            && !self.is_resumed_elsewhere(id, updating)
            && self.search.resets_in_pauses(self.region, mode);
        is_mode.then(|| Cause::Code(format!("what `{}` makes of the state that decides", law.text)))
    }

    /// Whether a call is a law of the instance, or of what holds it.
    fn is_law_of_owner(&self, site: &CallSite) -> bool {
        let filter = site.law_of.and_then(|number| site.args.get(number)?.place.as_ref());
        filter.is_none_or(|place| {
            let roots = self.search.aliases.shared_roots(place);
            roots.iter().any(|root| matches!(root.relate(self.search.instance, &|_| None), Relation::Holds(_)))
        })
    }
}
