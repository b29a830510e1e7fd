//! Numbers that go on by a constant: what is known of them behind that.

use super::State;
use super::run::Run;
use crate::flow::{Assignment, ChangeKind, OTHER_HEADS, Subject};

impl Run<'_, '_> {
    /// What is known of a number behind a node that counts it.
    pub(super) fn counted(&self, state: &State, target: usize) -> Option<u32> {
        let graph = self.search.graph;
        let change = graph.changes.get(&state.node)?;
        let subject = &graph.subjects[self.tracked.subjects[target].0 as usize];
        let before = self.masks.get(state.masks)[target];
        match change.tally.filter(|_| self.follows_numbers(target)) {
            Some(tally) => Some(tally.after(subject, before)),
            None => (change.kind == ChangeKind::CountsUp).then(|| above(subject, before)).flatten(),
        }
    }

    /// The bits of a number that is given a constant are known.
    pub(super) fn with_bits(&mut self, masks: u32, set: &Assignment) -> u32 {
        let Some(number) = set.head.as_ref().and_then(|head| head.parse::<u32>().ok()) else { return masks };
        let graph = self.search.graph;
        let mut all = self.masks.get(masks).clone();
        for (at, id) in self.tracked.subjects.iter().enumerate() {
            let subject = &graph.subjects[id.0 as usize];
            if let Some(bit) = subject.whole.as_ref().and_then(|whole| whole.bit_of(&set.place)) {
                all[at] = subject.bit(if number & bit != 0 { "true" } else { "false" });
            }
        }
        self.masks.intern(all)
    }

    /// A number of which more than one value is possible is followed for each of them where it goes on, so that what asks for it
    /// behind that tells what it was before. Answers whether it is one.
    pub(super) fn part_numbers(&mut self, at: usize, state: &State, set: &Assignment) -> bool {
        let graph = self.search.graph;
        if graph.changes.get(&state.node).is_none_or(|change| change.tally.is_none()) {
            return false;
        }
        let Some(target) = self.tracked_at(&set.place) else { return false };
        if !self.follows_numbers(target) || self.masks.get(state.masks)[target].count_ones() < 2 {
            return false;
        }
        self.assign_for_each(at, state, set, target);
        true
    }

    /// Whether it is worth while to follow each value of a number: something asks for it again, here or in what calls this.
    fn follows_numbers(&self, target: usize) -> bool {
        // Where there are many states, each would be there once for each number.
        self.needed.is_none() && (self.is_told(target) || self.tracked.often.contains(&self.tracked.subjects[target]))
    }
}

/// The heads that a number can have when it has gone up from one of these.
fn above(subject: &Subject, before: u32) -> Option<u32> {
    let known = subject.heads.iter().filter(|head| subject.bit(head) & before != 0);
    let least = known.map(|head| head.parse::<u64>().ok()).min()?.filter(|_| before & OTHER_HEADS == 0)?;
    let is_higher = |head: &&String| head.parse::<u64>().is_ok_and(|number| number > least);
    let higher = subject.heads.iter().filter(is_higher).fold(0, |mask, head| mask | subject.bit(head));
    Some((higher | OTHER_HEADS) & subject.anything())
}
