//! Conditions that a function and its callers share: what a way assumes of them, and which ways of a call they leave.

use std::collections::BTreeSet;

use super::run::Run;
use super::{Search, State};
use crate::count::assumed::{Assumed, Heads};
use crate::count::given::{Given, argument, asked_at, given_subject};
use crate::flow::{CallSite, Effect, NodeId, Place, SubjectId};

/// How many conditions of a caller's are told apart in a function for the caller's sake.
const MAX_TOLD: usize = 4;

/// What stands behind what is known of conditions, for one of a caller's that was not written yet: no condition has no heads.
pub(super) const UNWRITTEN: u32 = 0;

/// A condition of which a way tells callers what it assumes.
pub(super) struct OfCaller {
    /// Which of the tracked subjects it is.
    at: usize,
    /// What callers know it by.
    given: Given,
    /// Whether some way writes it.
    is_written: bool,
}

impl Search<'_> {
    /// The subjects that the ways through a call assume something of.
    pub(super) fn asked_by_call(&self, node: NodeId) -> BTreeSet<SubjectId> {
        match &self.graph.node(node).effect {
            Effect::Call(site) => self.called(site).asked.values().copied().collect(),
            _ => BTreeSet::new(),
        }
    }

    /// The subject that a function asks for where it is called, by this name or by another one of the only place that it can be.
    pub(super) fn asked_subject(&self, given: &Given, site: &CallSite) -> Option<SubjectId> {
        let place = asked_at(given, site)?;
        let roots = self.aliases.shared_roots(&place);
        let is_it =
            |whole: &Place| *whole == place || (roots.len() == 1 && *self.aliases.shared_roots(whole) == *roots);
        let found = self.graph.subjects.iter().position(|subject| subject.whole.as_ref().is_some_and(is_it))?;
        u32::try_from(found).ok().map(SubjectId)
    }

    /// The place that callers know a subject by.
    pub(in crate::count) fn of_caller(&self, id: SubjectId) -> Option<Given> {
        given_subject(self.graph, &self.graph.subjects[id.0 as usize])
    }
}

impl Run<'_, '_> {
    /// From now on, each end tells what its way assumes of conditions that callers know.
    pub(super) fn tell_assumed(&mut self) {
        let search = self.search;
        let graph = search.graph;
        let touching = search.touching();
        let branches = search.branches_before(touching.iter().copied());
        let of_branches = branches.into_iter().filter_map(|node| match &graph.node(node).effect {
            Effect::Branch(test) => test.subject,
            _ => None,
        });
        let of_calls = touching.iter().flat_map(|node| search.asked_by_call(*node));
        let asked: Vec<SubjectId> = of_branches.chain(of_calls).collect();
        // What nothing here changes tells callers most.
        let (kept, written): (Vec<SubjectId>, Vec<SubjectId>) =
            asked.into_iter().partition(|id| search.writers_of(*id).is_empty());
        let all = kept.into_iter().map(|id| (id, false)).chain(written.into_iter().map(|id| (id, true)));
        for (id, is_written) in all {
            if self.of_caller.len() >= MAX_TOLD {
                break;
            }
            let Some(given) = search.of_caller(id) else { continue };
            let at = self.tracked.subjects.iter().position(|tracked| *tracked == id).unwrap_or_else(|| {
                self.tracked.subjects.push(id);
                self.tracked.subjects.len() - 1
            });
            if !self.is_told(at) {
                self.of_caller.push(OfCaller { at, given, is_written });
            }
        }
    }

    /// What a way that ends with this state assumes: what was known of a condition when it was written for the first time, if it was.
    pub(super) fn assumed(&self, state: &State) -> Assumed {
        let masks = self.masks.get(state.masks);
        let (now, at_first_write) = masks.split_at(self.tracked.subjects.len());
        let told = self.of_caller.iter().zip(at_first_write);
        let heads = |told: &OfCaller, first: u32| {
            let mask = if first == UNWRITTEN { now[told.at] } else { first };
            let subject = &self.search.graph.subjects[self.tracked.subjects[told.at].0 as usize];
            Heads::of(subject, mask, first == UNWRITTEN && told.is_written)
        };
        told.filter_map(|(told, first)| Some((told.given.clone(), heads(told, *first)?))).collect()
    }

    /// Whether callers are told what is assumed of a tracked subject.
    pub(super) fn is_told(&self, at: usize) -> bool {
        self.of_caller.iter().any(|told| told.at == at)
    }

    /// Notes what is known of a condition of callers before it is written.
    pub(super) fn keep_assumed(&self, masks: &mut [u32], at: usize) {
        let Some(first) = self.before_first_write(at) else { return };
        if masks[first] == UNWRITTEN {
            masks[first] = masks[at];
        }
    }

    /// Where it stands what was known of a subject before it was written, if callers are told of it.
    fn before_first_write(&self, at: usize) -> Option<usize> {
        let told = self.of_caller.iter().position(|told| told.at == at)?;
        Some(self.tracked.subjects.len() + told)
    }

    /// What is known in a way through a call, if the way can be taken with what was known before.
    pub(super) fn agreed(&mut self, masks: u32, assumed: &Assumed, site: &CallSite, before: u32) -> Option<u32> {
        if assumed.is_empty() {
            return Some(masks);
        }
        let called = self.search.called(site);
        let before = self.masks.get(before).clone();
        let mut all = self.masks.get(masks).clone();
        for (given, heads) in assumed {
            // What is given may be a constant.
            if let Some(head) = argument(given, site).and_then(|argument| argument.head.as_ref()) {
                if heads.allows(head) {
                    continue;
                }
                return None;
            }
            let id = called.asked.get(given);
            let Some(at) = self.tracked.subjects.iter().position(|tracked| Some(tracked) == id) else { continue };
            let allowed = heads.as_of(&self.search.graph.subjects[self.tracked.subjects[at].0 as usize]);
            if before[at] & allowed == 0 {
                return None;
            }
            let reads = self.search.read_by(self.tracked.subjects[at]);
            let first = self.before_first_write(at);
            if !called.writes.keys().any(|place| reads.is_changed_with(place)) {
                all[at] &= allowed;
            } else if heads.is_kept && self.is_lent_once(at, site) {
                all[at] = before[at] & allowed;
                if let Some(first) = first {
                    all[first] = before[first];
                }
            } else if let Some(first) = first.filter(|first| before[*first] == UNWRITTEN) {
                // What the call writes may have another head behind it.
                all[first] &= allowed;
            }
            if all[at] == 0 {
                return None;
            }
        }
        Some(self.masks.intern(all))
    }

    /// Whether a call gets what a condition asks for by one argument only, so that no other one changes it unseen.
    fn is_lent_once(&self, at: usize, site: &CallSite) -> bool {
        let search = self.search;
        let reads = search.read_by(self.tracked.subjects[at]);
        let lends = |place: &Place| search.aliases.shared_roots(place).iter().any(|root| reads.is_changed_with(root));
        site.args.iter().filter_map(|arg| arg.place.as_ref()).filter(|place| lends(place)).count() <= 1
    }
}
