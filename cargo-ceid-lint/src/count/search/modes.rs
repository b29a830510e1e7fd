//! Whether a filter goes on after a pause with the state from before it: what tells a mode from a defect.

use super::run::Run;
use super::{Exploration, Region, Search, State};
use crate::count::counts::Count;
use crate::count::gates::Asks;
use crate::count::instances::is_lent;
use crate::count::outcome::Outcome;
use crate::count::slice::MAX_TRACKED;
use crate::count::verdict::Gate;
use crate::flow::{
    Assignment, CallSite, Effect, IndexKey, NodeId, OTHER_HEADS, Place, Projection, SubjectId, Test, Transfer, Var,
};
use crate::index::Ty;

/// How many states are followed at once.
const MAX_SUBJECTS: usize = 16;

/// How many names one behind another are followed to the place that they are made of.
const MAX_LENDERS: u32 = 8;

/// How many values of a state are followed one by one for the sake of callers.
const MAX_PARTED: u32 = 6;

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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in crate::count) struct Mode {
    /// What holds the state.
    pub(in crate::count) subject: SubjectId,
    /// The heads with which an update can be reached.
    pub(in crate::count) updating: u32,
    /// The call of the helper that asks for it, if one does.
    pub(in crate::count) asked_by: Option<NodeId>,
    /// What those ways of the helper wait for that ask for it: one that waits for a sample is no pause of the mode.
    pub(in crate::count) gate: Option<Gate>,
    /// The heads that others may give it between two calls of the function.
    pub(in crate::count) foreign: u32,
    /// Whether the laws of other filters are taken to leave every state as it is.
    pub(in crate::count) trusts_laws: bool,
}

impl Mode {
    /// A state that the function itself asks for, and that nothing else gives anything.
    pub(in crate::count) const fn new(subject: SubjectId, updating: u32) -> Self {
        Self { subject, updating, asked_by: None, gate: None, foreign: 0, trusts_laws: false }
    }
}

impl Search<'_> {
    /// Whether the filter is reset in each pause that a mode makes, before it runs again.
    pub(in crate::count) fn resets_in_pauses(&self, region: Region, mode: Mode) -> bool {
        let known = self.pauses.borrow().get(&(region, mode)).copied();
        known.unwrap_or_else(|| {
            let resets = self.find_resets_in_pauses(region, mode);
            self.pauses.borrow_mut().insert((region, mode), resets);
            resets
        })
    }

    /// The nodes of an iteration in which the filter stands still with its state from before, and at whose end its mode may be one in
    /// which it runs again: it does so without a reset, here or in the next one.
    pub(in crate::count) fn way_to_resume(
        &self,
        region: Region,
        mode: Mode,
        changes: &dyn Fn(NodeId) -> bool,
    ) -> Option<Vec<NodeId>> {
        let exploration = self.explore_pauses(region, mode);
        let resumed = exploration.states.iter().position(|state| state.age == Age::Resumed)?;
        let stale = exploration.ends.iter().filter(|end| end.state.age == Age::Stale).map(|end| end.at);
        let nodes = |at: usize| -> Vec<NodeId> {
            exploration.path(at).into_iter().map(|at| exploration.states[at].node).collect()
        };
        [resumed].into_iter().chain(stale).map(nodes).find(|way| way.iter().any(|node| changes(*node)))
    }

    /// Whether the filter is reset in the region after it ran, so that its pauses may end there. Where it never is, they last to the end.
    pub(in crate::count) fn begins_anew(&self, region: Region, mode: Mode) -> bool {
        let exploration = self.explore_pauses(region, mode);
        let states = &exploration.states;
        let has_run = |at: usize| exploration.parent(at).is_some_and(|before| states[before].age != Age::Fresh);
        (0..states.len()).any(|at| states[at].age == Age::Fresh && has_run(at))
    }

    fn find_resets_in_pauses(&self, region: Region, mode: Mode) -> bool {
        let exploration = self.explore_pauses(region, mode);
        self.gave_up.set(self.gave_up.get() || exploration.limit);
        !exploration.limit && exploration.states.iter().all(|state| state.age != Age::Resumed)
    }

    fn explore_pauses(&self, region: Region, mode: Mode) -> Exploration {
        let mut run = self.run(region, MAX_TRACKED);
        let compared = self.graph.subjects.iter().filter_map(crate::flow::Subject::equals);
        let compared =
            compared.flat_map(|(left, right)| [left, right]).filter_map(|place| self.graph.subject_of(place));
        let mut wanted: Vec<SubjectId> = [mode.subject].into_iter().chain(compared).collect();
        let mut number = 0;
        while let Some(subject) = wanted.get(number).copied().filter(|_| number < 2 * MAX_SUBJECTS) {
            if !run.tracked.subjects.contains(&subject) && run.tracked.subjects.len() < MAX_SUBJECTS {
                run.tracked.subjects.push(subject);
            }
            wanted.extend(self.copied_into(subject).filter(|from| !wanted.contains(from)).collect::<Vec<_>>());
            number += 1;
        }
        run.mode = Some(mode);
        // What is known from one iteration to the next is that of the tracked subjects alone.
        run.of_element.clear();
        run.finish(&self.starts(region))
    }
}

impl Search<'_> {
    /// Whether it is not known of a state that was asked whether it is a mode.
    pub(in crate::count) fn has_unknown_modes(&self) -> bool {
        self.gave_up.get()
    }

    /// The place of which a name is made in each iteration, if it is always the same one: `let state = &mut self.state;`
    pub(in crate::count) fn lent_always(&self, name: &Place) -> Option<Place> {
        let roots = self.aliases.shared_roots(name);
        let [root] = &*roots else { return None };
        let is_same = |step: &Projection| step.key().is_none_or(|key| matches!(key, IndexKey::Number(_)));
        let is_always = root != name && root.steps.iter().all(is_same) && self.is_lent_only(name, root, 0);
        is_always.then(|| root.clone())
    }

    /// Whether whatever gives a name its meaning takes it from there: `if is_there { p[3] } else { 0.0 }` does not.
    fn is_lent_only(&self, name: &Place, root: &Place, copies: u32) -> bool {
        let Some(var) = name.base_var().filter(|_| name.base != root.base) else { return true };
        let whole = Place::var(var);
        self.graph.node_ids().all(|node| match &self.graph.node(node).effect {
            Effect::Set(set) | Effect::Write(set) if set.place == whole => {
                let from = set.from.clone().or_else(|| set.same_as.map(Place::var));
                from.is_some_and(|from| copies < MAX_LENDERS && self.is_lent_only(&from, root, copies + 1))
            }
            _ => true,
        })
    }

    /// The states that something gives another one: `state = next(state, &mut filter)`.
    fn copied_into(&self, id: SubjectId) -> impl Iterator<Item = SubjectId> + '_ {
        let graph = self.graph;
        let whole = graph.subjects[id.0 as usize].whole.as_ref();
        let gives = move |node: &NodeId| match &graph.node(*node).effect {
            Effect::Set(set) | Effect::Write(set) => Some(&set.place) == whole,
            _ => false,
        };
        let from = graph.node_ids().filter(gives).filter_map(|node| graph.copied(node));
        from.filter_map(|place| graph.subject_of(&place))
    }
}

impl State {
    /// Whether nothing is left of an update before.
    pub(super) fn is_renewed(&self) -> bool {
        self.age == Age::Fresh
    }
}

impl Run<'_, '_> {
    /// The whole state is reset.
    pub(super) fn rejuvenate(&self, state: &mut State) {
        if self.follows_age() && state.age != Age::Resumed {
            state.age = Age::Fresh;
        }
    }

    /// A law runs.
    pub(super) fn wake(&self, state: &mut State) {
        if self.follows_age() {
            state.age = match state.age {
                Age::Fresh | Age::Live => Age::Live,
                Age::Stale | Age::Resumed => Age::Resumed,
            };
        }
    }

    /// Whether it matters what is left of the last update: for a mode, and for callers that ask whether a reset is behind it.
    fn follows_age(&self) -> bool {
        self.mode.is_some() || self.tells_renewal
    }

    /// The age at the end of an iteration: a pause that the mode made leaves what it found behind.
    pub(super) fn age_after(&self, state: &State) -> Age {
        let Some(mode) = &self.mode else { return state.age };
        let pauses = state.count == Count::Zero && state.age == Age::Live && self.is_pause(state, mode);
        if pauses { Age::Stale } else { state.age }
    }

    fn is_pause(&self, state: &State, mode: &Mode) -> bool {
        let asks = state.skipped_at.is_some_and(|at| match &self.search.graph.node(at).effect {
            Effect::Call(_) => mode.asked_by == Some(at) && state.helper_gate == mode.gate,
            Effect::Branch(test) => mode.asked_by == Some(at) || test.subject == Some(mode.subject),
            _ => mode.asked_by == Some(at),
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
        // What a parameter brings may be another one with each call, but for what lies behind an exclusive reference.
        let is_kept = |var: Var| {
            let info = graph.var(var);
            info.param.is_some() && (info.name == "self" || graph.leaves_behind(var))
        };
        let is_behind = |var: Var| matches!(graph.var(var).ty, Ty::Ref(true, _));
        let is_own = |place: &Place| match place.base_var() {
            Some(var) if place.steps.is_empty() => is_kept(var) && is_behind(var),
            Some(var) => is_kept(var) || is_lent(self.search.program.index, graph, place),
            None => true,
        };
        let outlives =
            |place: &Place| is_own(place) || self.search.lent_always(place).is_some_and(|root| is_own(&root));
        let known = self.masks.get(state.masks).clone();
        let others = self.mode.filter(|mode| mode.foreign != 0);
        let given = others.and_then(|mode| graph.subjects[mode.subject.0 as usize].whole.as_ref());
        let masks: Vec<u32> = self
            .tracked
            .subjects
            .iter()
            .zip(known)
            .map(|(id, mask)| {
                let subject = &graph.subjects[id.0 as usize];
                // What the function only reads is for others to change between two calls.
                let is_own = subject.reads.iter().all(outlives) && !self.search.writers_of(*id).is_empty();
                // How it compares with another state is not known either once others have given it something.
                let is_compared = subject.equals().is_some()
                    && given.is_some_and(|given| subject.reads.iter().any(|place| place.overlaps(given)));
                let is_own = is_own && !is_compared;
                let foreign = self.mode.filter(|mode| mode.subject == *id).map_or(0, |mode| mode.foreign);
                if is_own { mask | foreign } else { subject.anything() }
            })
            .collect();
        let masks = self.masks.intern(masks);
        let age = self.age_after(state);
        self.start_with(NodeId(0), None, masks, age);
    }

    /// A copy of a state whose value is not known is followed for each value it may have, so that both stay the same; for callers
    /// where there are few. Answers whether it is one.
    pub(super) fn part_copies(&mut self, at: usize, state: &State, set: &Assignment) -> bool {
        let copied = self.search.graph.copied(state.node);
        let Some((from, _)) = copied.and_then(|place| Some((self.tracked_at(&place)?, self.tracked_at(&set.place)?)))
        else {
            return false;
        };
        let values = self.masks.get(state.masks)[from].count_ones();
        let is_for_callers = self.needed.is_none() && self.is_told(from) && values <= MAX_PARTED;
        if values < 2 || !(self.mode.is_some() || is_for_callers) {
            return false;
        }
        self.assign_for_each(at, state, set, from);
        true
    }

    /// Follows an assignment once for each value that a tracked subject may have.
    pub(super) fn assign_for_each(&mut self, at: usize, state: &State, set: &Assignment, tracked: usize) {
        let all = self.masks.get(state.masks).clone();
        for bit in (0..u32::BITS).map(|number| 1 << number).filter(|bit| all[tracked] & bit != 0) {
            let mut own = all.clone();
            own[tracked] = bit;
            let masks = self.masks.intern(own);
            self.assign(at, &State { masks, ..state.clone() }, set);
        }
    }

    /// What may be known behind a comparison of two states; nothing if it cannot come out so.
    pub(super) fn compared(&mut self, masks: u32, test: &Test, are_equal: bool) -> Vec<u32> {
        let graph = self.search.graph;
        let asked = test.subject.map(|id| &graph.subjects[id.0 as usize]).filter(|_| self.mode.is_some());
        let Some((left, right)) = asked
            .and_then(crate::flow::Subject::equals)
            .and_then(|(left, right)| Some((self.tracked_at(left)?, self.tracked_at(right)?)))
        else {
            return vec![masks];
        };
        let mut all = self.masks.get(masks).clone();
        let subject = |at: usize| &graph.subjects[self.tracked.subjects[at].0 as usize];
        let of_right = subject(left).translate(all[right], &subject(right).heads);
        if are_equal {
            all[left] &= of_right;
            all[right] &= subject(right).translate(all[left], &subject(left).heads);
            // Each value that both may have is followed by itself, so that they stay the same.
            let bits = (0..u32::BITS).map(|number| 1_u32 << number).filter(|bit| all[left] & bit != 0);
            let mut found = Vec::new();
            for bit in bits {
                let mut own = all.clone();
                own[left] = bit;
                own[right] &= subject(right).translate(bit, &subject(left).heads);
                if own[right] != 0 {
                    found.push(self.masks.intern(own));
                }
            }
            found
        } else {
            let is_one = all[left].count_ones() == 1 && all[right].count_ones() == 1 && all[left] != OTHER_HEADS;
            if is_one && all[left] == of_right { Vec::new() } else { vec![masks] }
        }
    }

    /// Whether a name is made once more for the place that it was one of in the iteration before: what is known of a mode stays so.
    pub(super) fn is_lent_again(&self, set: &Assignment) -> bool {
        // A copy of a number or flag is another one as soon as the place is written.
        let is_reference = || {
            let held = set.place.base_var().map(|var| &self.search.graph.var(var).ty);
            held.is_none_or(|ty| matches!(ty, Ty::Ref(..) | Ty::Pointer(_)) || !self.search.program.index.is_copy(ty))
        };
        self.mode.is_some()
            && set.rebinds
            && set.transfer == Transfer::Borrow
            && set.place.steps.is_empty()
            && is_reference()
            && self.search.lent_always(&set.place).is_some()
    }

    /// Which of the tracked subjects a place is.
    pub(super) fn tracked_at(&self, place: &Place) -> Option<usize> {
        let graph = self.search.graph;
        let is_it = |id: &SubjectId| graph.subjects[id.0 as usize].whole.as_ref() == Some(place);
        self.tracked.subjects.iter().position(is_it)
    }

    /// What is known of a mode that a helper asks for, where a way through the helper is taken; `None` if it cannot be.
    pub(super) fn asked(&mut self, state: &State, outcome: &Outcome, site: &CallSite) -> Option<u32> {
        let Some(Mode { subject, updating, asked_by: Some(call), .. }) = self.mode else { return Some(state.masks) };
        if call != state.node || (outcome.count == Count::Zero && !self.asks_for_mode(outcome, site)) {
            return Some(state.masks);
        }
        let at = self.tracked.subjects.iter().position(|id| *id == subject)?;
        let mut all = self.masks.get(state.masks).clone();
        all[at] &= if outcome.count == Count::Zero { !updating } else { updating };
        (all[at] != 0).then(|| self.masks.intern(all))
    }

    /// What a way through a helper waits for. One that the helper takes for another reason than the mode is no pause of it.
    pub(super) fn gate_in(&self, state: &State, outcome: &Outcome, site: &CallSite) -> Option<Gate> {
        match &self.mode {
            Some(mode) if mode.asked_by == Some(state.node) && !self.asks_for_mode(outcome, site) => Some(Gate::Rate),
            _ => outcome.gate,
        }
    }

    fn asks_for_mode(&self, outcome: &Outcome, site: &CallSite) -> bool {
        let subject = outcome.asks.as_ref().and_then(|asks: &Asks| asks.subject(self.search.graph, site));
        subject.is_some() && subject == self.mode.map(|mode| mode.subject)
    }
}
