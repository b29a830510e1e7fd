//! What calls and assignments do to a state: counts, names, and what is known of conditions.

use super::called;
use super::names::is_concerned;
use super::run::{BEYOND, Run};
use super::{MAX_ROUNDS, State};
use crate::count::counts::Count;
use crate::count::given_heads::GivenHeads;
use crate::count::instances::place_ty;
use crate::count::outcome::Outcome;
use crate::count::returned;
use crate::count::verdict::Gate;
use crate::flow::{
    Assignment, CallSite, Cause, LoopId, LoopInfo, OTHER_HEADS, PAST, Place, Relation, Rounds, Subject, Transfer,
    Update, Var,
};
use crate::index::Ty;

/// How many steps a name may have: what is wrapped in itself in a loop has more with each round, without an end.
const MAX_STEPS: usize = 64;

impl Run<'_, '_> {
    pub(super) fn call(&mut self, at: usize, state: &State, site: &CallSite) {
        let search = self.search;
        let called = search.called(site);
        let goes_on = site.targets.is_empty() || !called.effects.is_empty();
        if goes_on
            && self.tracked.subjects.is_empty()
            && called.effects.iter().all(|effect| effect.outcomes.is_empty())
            && search.borrowed(self.names.get(state.names), site, &|var| self.number(state, var)).is_none()
            && site.hands.is_none()
            && self.copies_through(state, site) == state.copies
            && !self.is_untold_step(state, site)
        {
            self.everywhere(at, state);
            return;
        }
        let mut masks = state.masks;
        let before = masks;
        let trusts_laws = self.mode.is_some_and(|mode| mode.trusts_laws);
        let is_trusted = trusts_laws && site.law_of.is_some() && !self.is_receiver(state, site);
        masks = match is_trusted {
            true => self.killed(masks, &Place::var(site.result)),
            false => self.behind_writes(state.node, masks, &called, site),
        };
        let state = State { masks, ..state.clone() };
        let mut after: Vec<State> = Vec::new();
        let is_receiver = called.effects.iter().any(|effect| effect.is_of_others) && self.is_receiver(&state, site);
        for effect in called.effects.iter().filter(|effect| !(effect.is_of_others && is_receiver)) {
            let mut states = vec![(state.clone(), returned::ANY)];
            let mut applied = false;
            let is_exact = |relations: &[Relation]| {
                relations.iter().any(|relation| matches!(relation, Relation::Holds(rest) if rest.is_empty()))
            };
            let related: Vec<_> = effect
                .outcomes
                .iter()
                .map(|(place, outcomes)| (place, outcomes, self.relations_to_each(&state, place)))
                .collect();
            // What the function does to an element that it names is told with it, also what it does to each.
            let is_named =
                related.iter().any(|(place, _, relations)| !place.stands_for_several() && is_exact(relations));
            let mut told: Option<&Vec<Outcome>> = None;
            for (place, outcomes, relations) in related {
                let exact = is_exact(&relations);
                // Of several variants one is there.
                if exact && !search.homes().is_empty() {
                    match told {
                        None => told = Some(outcomes),
                        Some(first) => {
                            if first != outcomes {
                                let cause = self.cause(&called::which_variant());
                                for (state, _) in &mut states {
                                    state.unknown = Some(cause);
                                }
                            }
                            continue;
                        }
                    }
                }
                if exact && is_named && place.stands_for_several() {
                    continue;
                }
                let owner =
                    relations.iter().any(|relation| matches!(relation, Relation::Holds(rest) if !rest.is_empty()));
                let outcomes = &self.in_any_order(&state, place, outcomes);
                if exact {
                    applied = true;
                    let outcomes = super::versions::by_value(outcomes, place, site);
                    states = self.apply(&states, &outcomes, site, before);
                } else if owner {
                    states = self.apply_to_owner(&states, outcomes, site, before);
                } else if outcomes.iter().any(|outcome| outcome.count != Count::Zero || outcome.is_reordered())
                    && let Some(cause) = self.doubt(&state, place, &relations)
                {
                    let cause = self.cause(&cause);
                    for (state, _) in &mut states {
                        state.unknown = Some(cause);
                    }
                }
            }
            let is_untold = |(_, outcomes): &(Place, Vec<Outcome>)| {
                outcomes.iter().all(|outcome| outcome.returned == returned::ANY && outcome.assumed.is_empty())
            };
            // What a way gives back that says nothing of it, is what the function answers.
            let is_answered = || !effect.answers.is_empty() && effect.outcomes.iter().all(is_untold);
            if effect.heads != 0 && (!applied || is_answered()) {
                states = self.answered(states, effect, site, before);
            }
            if !applied {
                states = self.handed_through(states, site);
            }
            for (next, heads) in states {
                let masks = self.with_heads(next.masks, site.result, heads);
                after.push(State { masks, ..next });
            }
        }
        if site.targets.is_empty() {
            after.push(state);
        }
        for next in after {
            let (copies, versions) = (self.copies_through(&next, site), self.untold_after(&next, site));
            let next = State { copies, versions, ..next };
            let number = |var| self.number(&next, var);
            let Some((names, is_doubtful)) = search.borrowed(self.names.get(next.names), site, &number) else {
                self.everywhere(at, &next);
                continue;
            };
            let names = self.names.intern(names);
            let unknown = if is_doubtful { Some(self.cause(&Cause::Index(site.text.clone()))) } else { next.unknown };
            self.everywhere(at, &State { names, unknown, ..next });
        }
    }

    /// Whether a call has the instance, or what holds it, for its receiver.
    fn is_receiver(&self, state: &State, site: &CallSite) -> bool {
        let receiver = site.args.get(site.law_of.unwrap_or(0)).and_then(|arg| arg.place.as_ref());
        let relations = receiver.map(|place| self.relations_to_each(state, place)).unwrap_or_default();
        relations.iter().any(|relation| matches!(relation, Relation::Holds(_)))
    }

    /// What happens to the instance in a call; `before` is what was known before it.
    fn apply(
        &mut self,
        states: &[(State, returned::Heads)],
        outcomes: &[Outcome],
        site: &CallSite,
        before: u32,
    ) -> Vec<(State, returned::Heads)> {
        let mut after = Vec::new();
        for (state, heads) in states {
            for outcome in outcomes {
                let Some(masks) = self.agreed(state.masks, &outcome.assumed, &outcome.left, site, before) else {
                    continue;
                };
                let mut next = State { masks, ..state.clone() };
                let Some(masks) = self.asked(&next, outcome, site) else { continue };
                next.masks = masks;
                next.attempted |= outcome.attempted && next.count == Count::Zero;
                if outcome.reset && !outcome.renewed {
                    self.rejuvenate(&mut next);
                }
                self.add(&mut next, outcome.count);
                if outcome.renewed {
                    self.rejuvenate(&mut next);
                }
                if outcome.count == Count::Many {
                    next.count = Count::Many;
                }
                next.reset |= outcome.reset;
                next.direct |= outcome.direct && outcome.count != Count::Zero;
                if let Some(cause) = &outcome.unknown {
                    next.unknown = Some(self.cause(cause));
                    if outcome.is_reordered() || matches!(cause, Cause::Moved(_)) {
                        next.names = self.names.intern(Vec::new());
                    }
                }
                if outcome.count == Count::Zero {
                    let is_skipped = next.count == Count::Zero && !next.reset && next.skipped_at.is_some();
                    // What a helper would reset that runs no law is not there.
                    let is_absent = is_skipped && outcome.gate == Some(Gate::Config);
                    if is_absent {
                        next.skipped_at = Some(next.node);
                    }
                    // A helper behind the one that skipped only resets, and says nothing of why.
                    if is_absent || !is_skipped {
                        next.helper_gate = self.gate_in(state, outcome, site);
                    }
                }
                if let Some((result, given)) = site.handed() {
                    let base = self.ahead_at(state, given).unwrap_or(Count::Zero);
                    next.versions = self.with_version(next.versions, result, base.then(outcome.ahead));
                }
                let entry = (next, heads & outcome.returned);
                if entry.1 != 0 && !after.contains(&entry) {
                    after.push(entry);
                }
            }
        }
        after
    }

    /// What happens to the owner of the instance: a reset, or something unknown.
    fn apply_to_owner(
        &mut self,
        states: &[(State, returned::Heads)],
        outcomes: &[Outcome],
        site: &CallSite,
        before: u32,
    ) -> Vec<(State, returned::Heads)> {
        let mut after: Vec<(State, returned::Heads)> = Vec::new();
        for (state, heads) in states {
            for outcome in outcomes {
                let Some(masks) = self.agreed(state.masks, &outcome.assumed, &outcome.left, site, before) else {
                    continue;
                };
                let mut next = State { masks, ..state.clone() };
                next.reset |= outcome.reset;
                if outcome.reset {
                    self.rejuvenate(&mut next);
                }
                if let Some(cause) = &outcome.unknown {
                    next.unknown = Some(self.cause(cause));
                }
                let entry = (next, heads & outcome.returned);
                if entry.1 != 0 && !after.contains(&entry) {
                    after.push(entry);
                }
            }
        }
        after
    }

    /// A loop begins: what has held in one of its rounds may hold again.
    pub(super) fn begun_anew(&mut self, masks: u32, id: LoopId) -> u32 {
        let graph = self.search.graph;
        let Some((counter, _)) = graph.loop_info(id).counter else { return masks };
        let mut all = self.masks.get(masks).clone();
        for (at, id) in self.tracked.subjects.iter().enumerate() {
            let subject = &graph.subjects[id.0 as usize];
            if subject.heads.iter().any(|head| head == PAST) && subject.reads.contains(&Place::var(counter)) {
                all[at] = subject.anything();
            }
        }
        self.masks.intern(all)
    }

    /// An update of a state that is a number, or an array of them, changes the value that conditions ask for.
    pub(super) fn with_new_value(&mut self, state: &State, update: &Update) -> State {
        let search = self.search;
        let mut next = state.clone();
        let is_value = |ty: Ty| matches!(ty, Ty::Int | Ty::Float | Ty::Array(..));
        if !update.is_typed && place_ty(search.program.index, search.graph, &update.place).is_some_and(is_value) {
            for root in search.aliases.shared_roots(&update.place).iter() {
                next.masks = self.killed(next.masks, root);
            }
        }
        next
    }

    /// The result of a call has one of these heads.
    pub(super) fn with_heads(&mut self, masks: u32, result: Var, heads: returned::Heads) -> u32 {
        let graph = self.search.graph;
        let place = Place::var(result);
        let Some(at) =
            self.tracked.subjects.iter().position(|id| graph.subjects[id.0 as usize].whole.as_ref() == Some(&place))
        else {
            return masks;
        };
        let subject = &graph.subjects[self.tracked.subjects[at].0 as usize];
        let variants = self.search.program.variants;
        let mut mask = if heads & returned::of_others(variants, subject) != 0 { OTHER_HEADS } else { 0 };
        for (number, head) in subject.heads.iter().enumerate() {
            if heads & returned::bit(variants, head) != 0 {
                mask |= 1 << number;
            }
        }
        let mut all = self.masks.get(masks).clone();
        all[at] = mask & subject.anything();
        self.masks.intern(all)
    }

    /// What is known of the heads of a variable.
    pub(super) fn heads_of(&self, state: &State, var: Var) -> returned::Heads {
        let graph = self.search.graph;
        let place = Place::var(var);
        let tracked =
            self.tracked.subjects.iter().position(|id| graph.subjects[id.0 as usize].whole.as_ref() == Some(&place));
        let Some(tracked) = tracked else { return returned::ANY };
        let subject = &graph.subjects[self.tracked.subjects[tracked].0 as usize];
        returned::of_mask(self.search.program.variants, subject, self.masks.get(state.masks)[tracked])
    }

    pub(super) fn assign(&mut self, at: usize, state: &State, set: &Assignment) {
        if self.part_copies(at, state, set) || self.part_numbers(at, state, set) {
            return;
        }
        let may_go_back = match set.transfer {
            Transfer::RoundTrip => true,
            Transfer::Move | Transfer::Borrow => self.has_copies(state),
            Transfer::Copy => false,
        };
        if may_go_back {
            let ways = self.copied(state, set);
            self.exploration.leaves_out_copies |= ways.is_empty();
            for (state, set) in ways {
                self.give(at, &state, &set);
            }
            return;
        }
        let copies = self.copies_behind(state, set);
        self.give(at, &State { copies, ..state.clone() }, set);
    }

    /// A place gets a value.
    fn give(&mut self, at: usize, state: &State, set: &Assignment) {
        let graph = self.search.graph;
        let mut next = state.clone();
        let is_next = self.versions_after(&mut next, set);
        if !is_next && self.search.is_refilled(self.names.get(state.names), set, state.node) {
            next.names = self.names.intern(vec![self.search.instance.clone()]);
            next.reset = true;
            self.rejuvenate(&mut next);
        } else if !is_next && is_concerned(self.names.get(state.names), set) {
            let names = self.names.get(state.names);
            let (renamed, replaced) = self.search.renamed(names, set, state.node, &|var| self.number(state, var));
            if renamed.iter().any(|name| name.steps.len() > MAX_STEPS) {
                self.exploration.limit = true;
                return;
            }
            let number = |var| self.number(state, var);
            let chosen = self.search.chosen_of(names, set, &number);
            let chosen = chosen.or_else(|| self.search.pointed_somewhere(names, set, state.node, &number));
            let chosen = chosen.filter(|_| !set.from.as_ref().is_some_and(|from| self.is_other_round(state, from)));
            let chosen = chosen.or_else(|| self.gone_from(state, set, &renamed));
            next.names = self.names.intern(renamed);
            if let Some(cause) = chosen {
                next.unknown = Some(self.cause(&cause));
            }
            next.reset = (state.reset || replaced) && !self.search.is_carried_over(self.region, set);
            if replaced && self.is_ahead(&next) {
                next.unknown = Some(self.made_of_next());
            } else if replaced
                && set.from.is_none()
                && let Some(cause) = self.made_by_unread(state.node)
            {
                next.unknown = Some(self.cause(&cause));
            }
            if replaced && next.reset {
                self.rejuvenate(&mut next);
            }
        }
        // A copy of a variable has its heads.
        let copied = graph.copied(state.node).and_then(|place| {
            let from = self
                .tracked
                .subjects
                .iter()
                .position(|id| graph.subjects[id.0 as usize].whole.as_ref() == Some(&place))?;
            Some((from, self.masks.get(state.masks)[from]))
        });
        if !self.names_element(set) && !self.is_lent_again(set) {
            next.masks = self.killed(next.masks, &set.place);
        }
        for place in self.search.led_to_by(set, state.node).iter().flatten() {
            let given = GivenHeads { heads: set.head.iter().cloned().collect(), surely: true };
            next.masks = self.written(next.masks, place, set.head.as_ref().map(|_| &given));
        }
        // What is written through a reference is written where it points to; a reference that points elsewhere writes nothing.
        if !set.rebinds {
            for root in self.search.aliases.shared_roots(&set.place).iter().filter(|root| **root != set.place) {
                next.masks = self.killed(next.masks, root);
            }
        }
        let target = self
            .tracked
            .subjects
            .iter()
            .position(|id| graph.subjects[id.0 as usize].whole.as_ref() == Some(&set.place));
        if let Some(target) = target {
            let subject = &graph.subjects[self.tracked.subjects[target].0 as usize];
            let mask = match (&set.head, copied) {
                (Some(head), _) => Some(subject.bit(head)),
                (None, Some((from, mask))) => {
                    let source = &graph.subjects[self.tracked.subjects[from].0 as usize];
                    Some(subject.translate(mask, &source.heads))
                }
                (None, None) => self.counted(state, target),
            };
            if let Some(mask) = mask {
                let mut all = self.masks.get(next.masks).clone();
                all[target] = mask;
                next.masks = self.masks.intern(all);
            }
        }
        next.masks = self.with_bits(next.masks, set);
        if let Some(var) = set.place.base_var().filter(|_| set.place.steps.is_empty()) {
            next.masks = self.renumbered(next.masks, state, var);
        }
        self.everywhere(at, &next);
    }

    /// A variable that counts the rounds of a loop has the number of the round at hand, under whatever name the pattern binds it.
    fn renumbered(&mut self, masks: u32, state: &State, var: Var) -> u32 {
        let graph = self.search.graph;
        let is_counter = |id: LoopId| graph.loop_info(id).counter.is_some_and(|(counter, _)| counter == var);
        let open = self.rounds.get(state.rounds).iter().find(|(id, _)| is_counter(*id)).copied();
        let is_beyond = |id: LoopId, done| done == BEYOND || graph.loop_info(id).is_beyond(done, MAX_ROUNDS);
        match (open, self.number(state, var)) {
            (Some((id, done)), _) if is_beyond(id, done) && !self.search.covers(id) => {
                self.without_told(masks, var, graph.loop_info(id))
            }
            (Some(_), Some(number)) => self.with_number(masks, var, number),
            _ => masks,
        }
    }

    /// The greatest of the numbers that conditions compare a counter with, if they do.
    pub(super) fn last_asked(&self, counter: Var) -> Option<u64> {
        let subject = self.subject_of_counter(counter)?;
        subject.heads.iter().filter_map(|head| head.parse().ok()).max()
    }

    /// Whether conditions compare a counter with a number that it only has behind the rounds that are told apart.
    pub(super) fn asks_beyond(&self, counter: Var, info: &LoopInfo) -> bool {
        let asked = self.subject_of_counter(counter).into_iter().flat_map(|subject| &subject.heads);
        asked.filter_map(|head| head.parse().ok()).any(|number| !is_told(info, number) && info.has_number(number))
    }

    /// A counter has none of the numbers that conditions compare it with, but for those of the rounds that are not told apart.
    pub(super) fn without_told(&mut self, masks: u32, counter: Var, info: &LoopInfo) -> u32 {
        let Some(subject) = self.subject_of_counter(counter) else { return masks };
        let is_over = |number| is_told(info, number) || !info.has_number(number);
        let is_known = |head: &str| head.parse().is_ok_and(is_over);
        let known = subject.heads.iter().filter(|head| is_known(head)).fold(0, |mask, head| mask | subject.bit(head));
        let rest = subject.anything() & !known;
        let place = Place::var(counter);
        let graph = self.search.graph;
        let mut all = self.masks.get(masks).clone();
        for (at, id) in self.tracked.subjects.iter().enumerate() {
            if graph.subjects[id.0 as usize].whole.as_ref() == Some(&place) {
                all[at] = rest;
            }
        }
        self.masks.intern(all)
    }

    fn subject_of_counter(&self, counter: Var) -> Option<&Subject> {
        let place = Place::var(counter);
        let graph = self.search.graph;
        let all = self.tracked.subjects.iter().map(|id| &graph.subjects[id.0 as usize]);
        all.into_iter().find(|subject| subject.whole.as_ref() == Some(&place))
    }

    /// A counter has a number.
    pub(super) fn with_number(&mut self, masks: u32, counter: Var, number: u64) -> u32 {
        let graph = self.search.graph;
        let place = Place::var(counter);
        let Some(at) =
            self.tracked.subjects.iter().position(|id| graph.subjects[id.0 as usize].whole.as_ref() == Some(&place))
        else {
            return masks;
        };
        let subject = &graph.subjects[self.tracked.subjects[at].0 as usize];
        let mut all = self.masks.get(masks).clone();
        // A counter that goes over variants has their names.
        all[at] = match graph.var(counter).ty.peel() {
            Ty::Adt(id, _) => match self.search.program.index.variant_numbered(*id, number) {
                Some(variant) => subject.bit(variant),
                None => return masks,
            },
            _ => subject.bit(&number.to_string()),
        };
        self.masks.intern(all)
    }
}

/// Whether a counter has a number in none but the rounds that are told apart, if it has it at all.
fn is_told(info: &LoopInfo, number: u64) -> bool {
    // Of rounds whose number is known, the last one that is told apart stands for all behind it.
    let last = if matches!(info.rounds, Rounds::Constant(_)) { MAX_ROUNDS - 1 } else { MAX_ROUNDS };
    match info.number_in(last) {
        Some(last) if info.counts_down => number >= last,
        Some(last) => number <= last,
        None => false,
    }
}
