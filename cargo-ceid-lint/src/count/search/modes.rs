//! Whether a filter goes on after a pause with the state from before it: what tells a mode from a defect.

use super::run::Run;
use super::{Region, Search, State};
use crate::count::counts::Count;
use crate::flow::{Assignment, Effect, NodeId, Place, SubjectId};

/// What is left of a filter's last update.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) enum Age {
    /// Nothing: it was reset, or never ran.
    #[default]
    Fresh,
    /// It ran in the iteration before.
    Live,
    /// It paused since, and was not reset.
    Stale,
    /// It was updated although it was stale.
    Resumed,
}

/// A state of the program that says whether a filter runs.
#[derive(Clone, Copy, Debug)]
pub(in crate::count) struct Mode {
    /// What holds the state.
    pub(in crate::count) subject: SubjectId,
    /// The heads with which an update can be reached.
    pub(in crate::count) updating: u32,
}

impl Search<'_> {
    /// Whether the filter is reset in each pause that a mode makes, before it runs again.
    pub(in crate::count) fn resets_in_pauses(&self, region: Region, mode: Mode) -> bool {
        let mut run = self.run(region, std::collections::BTreeSet::new());
        if !run.tracked.subjects.contains(&mode.subject) {
            return false;
        }
        run.mode = Some(mode);
        for (node, entry) in self.starts(region) {
            run.start(node, entry.as_ref());
        }
        let exploration = run.finish();
        !exploration.limit && exploration.states.iter().all(|state| state.age != Age::Resumed)
    }
}

impl Run<'_, '_> {
    /// The whole state is reset.
    pub(super) fn rejuvenate(&self, state: &mut State) {
        if self.mode.is_some() && state.age != Age::Resumed {
            state.age = Age::Fresh;
        }
    }

    /// A law runs.
    pub(super) fn wake(&self, state: &mut State) {
        if self.mode.is_some() {
            state.age = match state.age {
                Age::Fresh | Age::Live => Age::Live,
                Age::Stale | Age::Resumed => Age::Resumed,
            };
        }
    }

    /// The age at the end of an iteration: a pause that the mode made leaves what it found behind.
    pub(super) fn age_after(&self, state: &State) -> Age {
        let Some(mode) = &self.mode else { return state.age };
        let pauses = state.count == Count::Zero && state.age == Age::Live && self.is_pause(state, mode);
        if pauses { Age::Stale } else { state.age }
    }

    fn is_pause(&self, state: &State, mode: &Mode) -> bool {
        let asks = state.skipped_at.is_some_and(|at| {
            matches!(&self.search.graph.node(at).effect, Effect::Branch(test) if test.subject == Some(mode.subject))
        });
        let tracked = self.tracked.subjects.iter().position(|id| *id == mode.subject);
        asks || tracked.is_some_and(|at| self.masks.get(state.masks)[at] & mode.updating == 0)
    }

    /// A function that is a cycle is called again: what outlives the call is still known.
    pub(super) fn again(&mut self, state: &State) {
        if self.mode.is_none() {
            return;
        }
        let graph = self.search.graph;
        let outlives = |place: &Place| match place.base_var() {
            Some(var) => graph.var(var).param.is_some() && !place.steps.is_empty(),
            None => true,
        };
        let known = self.masks.get(state.masks).clone();
        let masks: Vec<u32> = self
            .tracked
            .subjects
            .iter()
            .zip(known)
            .map(|(id, mask)| {
                let subject = &graph.subjects[id.0 as usize];
                if subject.reads.iter().all(outlives) { mask } else { subject.anything() }
            })
            .collect();
        let masks = self.masks.intern(masks);
        let age = self.age_after(state);
        self.start_with(NodeId(0), None, masks, age);
    }

    /// A copy of a state whose value is not known is followed for each value it may have, so that both stay the same. Answers
    /// whether it is one.
    pub(super) fn part_copies(&mut self, at: usize, state: &State, set: &Assignment) -> bool {
        let graph = self.search.graph;
        let tracked = |place: &Place| {
            let is_it = |id: &SubjectId| graph.subjects[id.0 as usize].whole.as_ref() == Some(place);
            self.tracked.subjects.iter().position(is_it)
        };
        let Some((from, _)) = graph
            .copied(state.node)
            .filter(|_| self.mode.is_some())
            .and_then(|place| Some((tracked(&place)?, tracked(&set.place)?)))
        else {
            return false;
        };
        let all = self.masks.get(state.masks).clone();
        if all[from].count_ones() < 2 {
            return false;
        }
        for bit in (0..u32::BITS).map(|number| 1 << number).filter(|bit| all[from] & bit != 0) {
            let mut own = all.clone();
            own[from] = bit;
            let masks = self.masks.intern(own);
            self.assign(at, &State { masks, ..state.clone() }, set);
        }
        true
    }
}
