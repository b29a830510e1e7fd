//! How many cycles lie between two openings of a gate that asks for a count, found by counting.

use std::collections::BTreeSet;

use super::{Region, Search};
use crate::flow::{Change, ChangeKind, Effect, NodeId, Place, Subject, Test};

/// How many cycles are counted.
const MAX_CYCLES: u64 = 20_000;

/// How many nodes all of them may come to.
const MAX_STEPS: usize = 4_000_000;

/// A count that nothing changes but constants and steps of one size.
struct Counter<'s> {
    subject: &'s Subject,
    place: &'s Place,
    writers: BTreeSet<NodeId>,
    updating: BTreeSet<NodeId>,
}

impl Search<'_> {
    /// How many cycles lie between two updates where a gate asks for a count; `None` if that depends on more than the count.
    pub(in crate::count) fn period(&self, region: Region, test: &Test) -> Option<u64> {
        let id = test.subject?;
        let subject = &self.graph.subjects[id.0 as usize];
        let [place] = subject.reads.as_slice() else { return None };
        if !self.outlives(region, place) || place.base_var().is_none() {
            return None;
        }
        let all = self.writers_of(id);
        let starts = all.iter().filter_map(|writer| self.number_set(*writer, place)).collect::<BTreeSet<u64>>();
        let writers: BTreeSet<NodeId> =
            all.iter().copied().filter(|id| region.holds(self.graph, self.graph.node(*id).in_loop)).collect();
        let counter = Counter { subject, place, writers, updating: self.updating() };
        let mut left = MAX_STEPS;
        let mut found = None;
        // What comes round by itself may begin anywhere.
        let starts = if starts.is_empty() { BTreeSet::from([0]) } else { starts };
        for start in starts {
            let own = self.period_from(region, &counter, start, &mut left)?;
            if found.is_some_and(|found| found != own) {
                return None;
            }
            found = Some(own);
        }
        found
    }

    /// The number that an assignment sets a place to.
    fn number_set(&self, id: NodeId, place: &Place) -> Option<u64> {
        match &self.graph.node(id).effect {
            Effect::Set(set) | Effect::Write(set) if set.place == *place => match set.head.as_deref()? {
                "true" => Some(1),
                "false" => Some(0),
                head => head.parse().ok(),
            },
            _ => None,
        }
    }

    fn period_from(&self, region: Region, counter: &Counter<'_>, start: u64, left: &mut usize) -> Option<u64> {
        let mut number = start;
        let mut opened = Vec::new();
        for cycle in 0..MAX_CYCLES {
            let (next, opens) = self.cycle_from(region, counter, number, left)?;
            number = next;
            if opens {
                opened.push(cycle);
            }
            // The first one may come early or late.
            if let [.., before, last, newest] = opened.as_slice() {
                return (newest - last == last - before).then_some(newest - last);
            }
        }
        None
    }

    /// The number behind a cycle that begins with one, and whether it updates; `None` if several ways through it differ in that.
    fn cycle_from(&self, region: Region, counter: &Counter<'_>, number: u64, left: &mut usize) -> Option<(u64, bool)> {
        let graph = self.graph;
        let head = match region {
            Region::Function => NodeId(0),
            Region::Loop(own) => graph.loop_info(own).head,
        };
        let mut ends = BTreeSet::new();
        let mut seen = BTreeSet::new();
        let mut open = vec![(head, number, false)];
        while let Some((id, number, opens)) = open.pop() {
            if !seen.insert((id, number, opens)) {
                continue;
            }
            *left = left.checked_sub(1)?;
            let node = graph.node(id);
            let opens = opens || counter.updating.contains(&id);
            let after = if counter.writers.contains(&id) { self.number_after(id, counter, number)? } else { number };
            if matches!((region, &node.effect), (Region::Function, Effect::Return(_))) {
                ends.insert((after, opens));
            }
            for (edge, next) in node.next.iter().enumerate() {
                if let Effect::Branch(test) = &node.effect
                    && !counter.leads(test, edge, number, || test.subject.map(|id| &graph.subjects[id.0 as usize]))
                {
                    continue;
                }
                if matches!(region, Region::Loop(_)) && *next == head {
                    ends.insert((after, opens));
                } else if region.holds(graph, graph.node(*next).in_loop) {
                    open.push((*next, after, opens));
                }
            }
        }
        let mut ends = ends.into_iter();
        ends.next().filter(|_| ends.next().is_none())
    }

    fn number_after(&self, id: NodeId, counter: &Counter<'_>, number: u64) -> Option<u64> {
        if let Some(set) = self.number_set(id, counter.place) {
            return Some(set);
        }
        let change: &Change = self.graph.changes.get(&id)?;
        match (&self.graph.node(id).effect, change.kind) {
            (Effect::Set(set) | Effect::Write(set), _) if set.place != *counter.place => None,
            (_, ChangeKind::Toggles) => 1_u64.checked_sub(number),
            _ => change.tally?.next(number),
        }
    }
}

impl Counter<'_> {
    /// Whether a branch may take an edge where the count is a number.
    fn leads<'s>(&self, test: &Test, edge: usize, number: u64, asked: impl Fn() -> Option<&'s Subject>) -> bool {
        if let Some(own) = test.about.number.as_deref().filter(|own| own.of == *self.place) {
            return own.holds(number) == (edge == 0);
        }
        let Some(subject) = asked().filter(|subject| subject.whole.as_ref() == Some(self.place)) else { return true };
        let is_truth = self.subject.heads.iter().any(|head| matches!(head.as_str(), "true" | "false"));
        let head = if is_truth { (number != 0).to_string() } else { number.to_string() };
        let heads = if edge == 0 { test.holds } else { test.fails };
        heads & subject.bit(&head) != 0
    }
}
