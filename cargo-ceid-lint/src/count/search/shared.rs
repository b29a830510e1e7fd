//! Conditions that a function and its callers share: what a way assumes of them, and which ways of a call they leave.

use std::collections::BTreeSet;
use std::rc::Rc;

use super::run::Run;
use super::{Search, State};
use crate::count::answers::Answer;
use crate::count::assumed::{Assumed, Heads, is_open_to};
use crate::count::counts::Count;
use crate::count::declared::state_ty;
use crate::count::given::{Given, argument, asked_at, given_subject, is_left_there};
use crate::count::returned;
use crate::flow::{CallSite, Effect, NodeId, Place, Subject, SubjectId};

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
        let place = asked_at(given, site).filter(|place| !self.is_cell_of_static(place))?;
        let roots = self.aliases.shared_roots(&place);
        // Two options that refer to the same filter are two.
        let has_names = roots.len() == 1 && !self.refers(&place);
        let ty_of = |place: &Place| state_ty(self.program.index, self.graph, place);
        let own = ty_of(&place);
        let is_name = |whole: &Place| *self.aliases.shared_roots(whole) == *roots && ty_of(whole) == own;
        let is_it = |whole: &Place| *whole == place || (has_names && is_name(whole));
        let found = self.graph.subjects.iter().position(|subject| subject.known_as().is_some_and(is_it))?;
        u32::try_from(found).ok().map(SubjectId)
    }

    /// Whether the constants among its arguments leave a call no way that updates.
    pub(super) fn is_closed_call(&self, node: NodeId) -> bool {
        let Effect::Call(site) = &self.graph.node(node).effect else { return false };
        let places = self.aliases.called_places(site, self.summaries);
        let own = places.iter().filter(|called| self.may_reach(called, true));
        let mut ways = own.flat_map(|called| called.outcomes(self.summaries));
        !ways.any(|way| way.count != Count::Zero && is_open_to(&way.assumed, site))
    }

    /// Whether what a function writes there may be in the caller's place afterwards: what it gets by value is its own, unless it is what
    /// it gives back.
    fn is_behind(&self, subject: &Subject) -> bool {
        let base = subject.known_as().and_then(Place::base_var);
        base.is_some_and(|var| self.graph.leaves_behind(var))
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
        // What is asked of copies of them, too, and last what their values are made of: `let is_idle = !self.is_on; if is_idle { … }`.
        let followed = self.tracked.subjects.clone();
        let made_of = self.tracked.once.clone();
        let written = (0u32..).zip(&graph.subjects).filter(|(_, subject)| subject.is_of_callers);
        let written = written.map(|(number, _)| SubjectId(number));
        let asked: Vec<SubjectId> = of_branches.chain(of_calls).chain(followed).chain(written).collect();
        let made_of: Vec<SubjectId> = made_of.into_iter().filter(|id| !asked.contains(id)).collect();
        let mut all: Vec<(SubjectId, bool)> = asked
            .into_iter()
            .chain(made_of.iter().copied())
            .map(|id| (id, !search.writers_of(id).is_empty()))
            .collect();
        // States tell callers more than other questions, and what nothing here changes more than what is written.
        let is_question = |id: &SubjectId| graph.subjects[id.0 as usize].whole.is_none();
        all.sort_by_key(|(id, is_written)| (made_of.contains(id), is_question(id), *is_written));
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

    /// What a way that ends with this state assumes: what was known of a condition when it was written for the first time, if it was;
    /// and what is known at its end of those that it has written.
    pub(super) fn assumed(&self, state: &State) -> (Assumed, Assumed) {
        let masks = self.masks.get(state.masks);
        let (now, at_first_write) = masks.split_at(self.tracked.subjects.len());
        let (mut assumed, mut left) = (Assumed::new(), Assumed::new());
        for (told, first) in self.of_caller.iter().zip(at_first_write) {
            let subject = &self.search.graph.subjects[self.tracked.subjects[told.at].0 as usize];
            let is_unwritten = *first == UNWRITTEN;
            let before = if is_unwritten { now[told.at] } else { *first };
            let heads = Heads::of(subject, before, is_unwritten && told.is_written);
            assumed.extend(heads.map(|heads| (told.given.clone(), heads)));
            let is_left = !is_unwritten && self.search.is_behind(subject);
            let heads = if is_left { Heads::of(subject, now[told.at], false) } else { None };
            left.extend(heads.map(|heads| (told.given.clone(), heads)));
        }
        (assumed, left)
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

    /// What is known of the result of a call that leaves the instance alone.
    pub(super) fn answered(
        &mut self,
        states: Vec<(State, returned::Heads)>,
        effect: &super::called::Effect,
        site: &CallSite,
        before: u32,
    ) -> Vec<(State, returned::Heads)> {
        if effect.answers.is_empty() {
            return states.into_iter().map(|(state, heads)| (state, heads & effect.heads)).collect();
        }
        let mut after = Vec::new();
        for (state, heads) in states {
            for Answer { assumed, left, returned } in &effect.answers {
                let Some(masks) = self.agreed(state.masks, assumed, left, site, before) else { continue };
                let entry = (State { masks, ..state.clone() }, heads & effect.heads & returned);
                if entry.1 != 0 && !after.contains(&entry) {
                    after.push(entry);
                }
            }
        }
        after
    }

    /// What is known in a way through a call, if the way can be taken with what was known before.
    pub(super) fn agreed(
        &mut self,
        masks: u32,
        assumed: &Assumed,
        left: &Assumed,
        site: &CallSite,
        before: u32,
    ) -> Option<u32> {
        if assumed.is_empty() && left.is_empty() {
            return Some(masks);
        }
        let asked_of = self.asked_of(site);
        let before = self.masks.shared(before);
        // Most ways through a call cannot be taken, and need no copy of what is known.
        let mut all = self.masks.shared(masks);
        for (given, heads) in assumed {
            // What is given may be a constant.
            if let Some(head) = argument(given, site).and_then(|argument| argument.head.as_ref()) {
                if heads.allows(head) {
                    continue;
                }
                return None;
            }
            let Some(asked) = asked_of.get(given) else { continue };
            let at = asked.at;
            let allowed = heads.as_of(&self.search.graph.subjects[self.tracked.subjects[at].0 as usize]);
            if before[at] & allowed == 0 {
                return None;
            }
            let first = self.before_first_write(at);
            if !self.is_written_by(asked, site) {
                Rc::make_mut(&mut all)[at] &= allowed;
            } else if heads.is_kept && self.is_lent_once(asked, site) {
                let all = Rc::make_mut(&mut all);
                all[at] = before[at] & allowed;
                if let Some(first) = first {
                    all[first] = before[first];
                }
            } else if let Some(first) = first.filter(|first| before[*first] == UNWRITTEN) {
                // What the call writes may have another head behind it.
                Rc::make_mut(&mut all)[first] &= allowed;
            }
            if all[at] == 0 {
                return None;
            }
        }
        let is_trusted = site.law_of.is_some() && self.mode.is_some_and(|mode| mode.trusts_laws);
        let is_left = |given: &Given| !is_trusted && is_left_there(self.search.program.index, given, site);
        for (given, heads) in left.iter().filter(|(given, _)| is_left(given)) {
            let Some(asked) = asked_of.get(given) else { continue };
            if self.is_written_by(asked, site) && self.is_lent_once(asked, site) {
                let at = asked.at;
                Rc::make_mut(&mut all)[at] =
                    heads.as_of(&self.search.graph.subjects[self.tracked.subjects[at].0 as usize]);
            }
        }
        Some(self.masks.intern_shared(all))
    }
}
