//! The rounds of the loops that a way goes through.

use super::run::{BEYOND, Run};
use super::{MAX_ROUNDS, Region, State};
use crate::flow::{Assignment, Cause, LoopId, NodeId, Place, Rounds};

impl Run<'_, '_> {
    /// Another round of a loop, or no more.
    pub(super) fn head(&mut self, at: usize, state: &State, id: LoopId) {
        let graph = self.search.graph;
        let info = graph.loop_info(id);
        let next = graph.node(state.node).next.clone();
        let [round, rest @ ..] = next.as_slice() else { return };
        let names = self.names.get(state.names).clone();
        let plain = self.search.without_items(&names, id);
        let is_own = self.region == Region::Loop(id) && self.is_round_of_element();
        let named = if is_own { self.search.with_items(&plain, id) } else { plain.clone() };
        let plain_id = self.names.intern(named);
        let Some(copies) = self.copies_in_round(state.copies, id, false) else { return };
        let masks = if is_own { self.in_next_iteration(state.masks, id) } else { state.masks };
        let state = State { names: plain_id, copies, masks, ..state.clone() };
        let mut rounds = self.rounds.get(state.rounds).clone();
        let done = rounds.iter().find(|(open, _)| *open == id).map_or(0, |(_, done)| *done);
        let is_region = self.region == Region::Loop(id);
        let state = match self.chosen_in(&state, &plain, id).filter(|_| !is_region && self.updates_in(id)) {
            Some(cause) => State { unknown: Some(self.cause(&cause)), ..state },
            None => state,
        };
        // Nobody's round is among none: `filters.drain(..)` where all were drained before.
        let is_none = info.rounds == Rounds::Constant(0);
        if self.search.covers(id) && !is_region && !is_none {
            let own = self.search.with_items(&plain, id);
            // What holds references may hold no more of the instance where it was emptied, or not filled.
            let is_entered = info.is_entered || matches!(info.rounds, Rounds::Constant(rounds) if rounds > 0);
            let is_of_others = !is_entered && !info.items.is_empty() && own.len() == plain.len();
            if is_of_others && state.unknown.is_none() {
                for to in rest {
                    self.follow(at, state.clone(), *to);
                }
            }
            let own = self.names.intern(own);
            // The rounds before the instance's own: their number if it is known, or else any.
            let before = self.search.rounds_before(&plain, id).filter(|before| *before < MAX_ROUNDS);
            rounds.retain(|(open, _)| *open != id);
            // Which number the instance's own round has is known where those before it are; that of a later one never is.
            let passed = self.rounds.intern(rounds.iter().copied().chain([(id, BEYOND)]).collect());
            rounds.push((id, if before.is_some() { done.saturating_add(1) } else { BEYOND }));
            let more = self.rounds.intern(rounds);
            if done == before.unwrap_or(0) {
                let copies = self.copies_in_round(copies, id, true).unwrap_or(copies);
                self.follow(at, State { names: own, copies, rounds: more, ..state.clone() }, *round);
            }
            match before {
                Some(before) if done < before => self.follow(at, State { rounds: more, ..state.clone() }, *round),
                Some(before) if done == before => {}
                None if done == 0 => self.follow(at, state.clone(), *round),
                _ => self.follow(at, State { rounds: passed, ..state.clone() }, *round),
            }
            if done > before.unwrap_or(0) || self.search.passes_over(id) {
                for to in rest {
                    self.follow(at, state.clone(), *to);
                }
            }
            return;
        }
        if let Rounds::Constant(count) = info.rounds
            && !is_region
        {
            let last = count.min(MAX_ROUNDS);
            if done < last || (count > MAX_ROUNDS && done == last) {
                let now = (done + 1).min(last);
                rounds.retain(|(open, _)| *open != id);
                rounds.push((id, now));
                let more = self.rounds.intern(rounds);
                let mut after = State { rounds: more, ..state.clone() };
                if let Some((counter, _)) = info.counter {
                    after.masks = self.killed(after.masks, &Place::var(counter));
                    if count <= MAX_ROUNDS
                        && let Some(number) = info.number_in(now)
                    {
                        after.masks = self.with_number(after.masks, counter, number);
                    }
                    if info.is_beyond(now, MAX_ROUNDS) && self.asks_beyond(counter, info) && self.updates_in(id) {
                        self.exploration.limit = true;
                        return;
                    }
                }
                self.follow(at, after, *round);
            }
            if done >= last || (info.passes_over) {
                for to in rest {
                    self.follow(at, state.clone(), *to);
                }
            }
            return;
        }
        if info.has_untold_rounds() && !is_region && !self.search.sample_loops.contains(&id) && self.updates_in(id) {
            // Each type or build has its own number of rounds.
            let cause = Cause::Limit(format!("how often the loop over `{}` runs is not known", info.text));
            let unknown = Some(self.cause(&cause));
            if done == 0 {
                rounds.push((id, 1));
                let rounds = self.rounds.intern(rounds);
                self.follow(at, State { unknown, rounds, ..state.clone() }, *round);
            }
            for to in rest {
                self.follow(at, State { unknown, ..state.clone() }, *to);
            }
            return;
        }
        let mut after = state.clone();
        let is_first = info.is_entered && !info.passes_over && !is_region && done == 0 && info.counter.is_none();
        if is_first {
            rounds.push((id, BEYOND));
            after.rounds = self.rounds.intern(rounds.clone());
        }
        if let Some((counter, first)) = info.counter.filter(|_| !is_own) {
            after.masks = self.killed(after.masks, &Place::var(counter));
            if let (Some(first), Some(last), false) = (first, self.last_asked(counter), is_region || !info.in_order) {
                // Behind the last number that is asked for, no such question holds.
                let now = if done < MAX_ROUNDS && first.saturating_add(done) <= last { done + 1 } else { BEYOND };
                rounds.retain(|(open, _)| *open != id);
                rounds.push((id, now));
                after.rounds = self.rounds.intern(rounds);
                after.masks = match now {
                    BEYOND => self.without_told(after.masks, counter, info),
                    now => self.with_number(after.masks, counter, first + now - 1),
                };
            }
        }
        self.follow(at, after, *round);
        if is_first {
            return;
        }
        for to in rest {
            self.follow(at, state.clone(), *to);
        }
    }

    /// Why the items of a loop may be the instance or not: they are some of several references, and data says which.
    fn chosen_in(&self, state: &State, names: &[Place], id: LoopId) -> Option<Cause> {
        let sources = self.search.graph.loop_info(id).items.iter().map(|(_, source)| source);
        let number = |var| self.number(state, var);
        let cause = sources.into_iter().find_map(|source| self.search.chosen_from(names, source, &number))?;
        (self.search.with_items(names, id).len() == names.len()).then_some(cause)
    }

    /// What is known in the next round of the same element, which is one of the next iteration: what that gives anew may be anything.
    fn in_next_iteration(&mut self, masks: u32, id: LoopId) -> u32 {
        let graph = self.search.graph;
        let parent = graph.loop_info(id).parent;
        let is_anew = |node: &NodeId| {
            let within = graph.node(*node).in_loop;
            !graph.is_within(within, id) && parent.is_none_or(|parent| graph.is_within(within, parent))
        };
        let is_given = |place: &Place| {
            let var = place.base_var().filter(|_| parent.is_none());
            let info = var.map(|var| (graph.var(var), graph.leaves_behind(var)));
            info.is_some_and(|(info, is_lent)| info.param.is_some() && info.name != "self" && !is_lent)
        };
        let mut all = self.masks.get(masks).clone();
        for (at, subject) in self.tracked.subjects.iter().enumerate() {
            let own = &graph.subjects[subject.0 as usize];
            if own.reads.iter().any(is_given) || self.search.writers_of(*subject).iter().any(is_anew) {
                all[at] = own.anything();
            }
        }
        self.masks.intern(all)
    }

    /// Whether the iterations that are followed for a mode are the rounds of a loop over elements: each is one of the same element.
    pub(super) fn is_round_of_element(&self) -> bool {
        self.mode.is_some() && matches!(self.region, Region::Loop(id) if self.search.covers(id))
    }

    /// Whether a node gives the element of such a round its name, which is the one that it had in the round before.
    pub(super) fn names_element(&self, set: &Assignment) -> bool {
        let Region::Loop(id) = self.region else { return false };
        let var = set.place.base_var().filter(|_| set.rebinds && set.place.steps.is_empty());
        var.is_some_and(|var| self.search.graph.loop_info(id).bound.contains(&var)) && self.is_round_of_element()
    }

    /// Whether something in a loop updates the instance.
    fn updates_in(&self, id: LoopId) -> bool {
        let graph = self.search.graph;
        self.search.updating().into_iter().any(|node| graph.is_within(graph.node(node).in_loop, id))
    }
}
