//! Collections that have to fill before the filter runs: once, where they keep what they have come to, or again and again, where
//! what is behind the gate takes it out.

use std::collections::BTreeSet;

use super::{Gates, Way};
use crate::count::search::Region;
use crate::count::verdict::Gate;
use crate::flow::{AskedLength, Effect, LengthBound, NodeId, Place, Resized, Test};

/// How far from the bound lengths are told apart; at both ends are all those that lie behind.
const REACH: i64 = 6;

/// A length, as what it has more than the bound.
type Excess = i64;

impl Gates<'_, '_> {
    /// `self.window.push_back(x); if self.window.len() < 8 { continue; } self.window.pop_front();`: the window is full once and stays
    /// so. `block.push(x); if block.len() == 16 { filter.update(mean(&block)); block.clear(); }` divides the rate.
    pub(super) fn of_window(&self, test: &Test, at: NodeId, way: &Way) -> Option<Gate> {
        let asked = test.about.length.as_deref()?;
        let closed = way.after(at)?;
        let window = Window { gates: self, asked, at, closed, way };
        if !self.outlives(&asked.of) || !window.is_followed() || self.is_resized_elsewhere(&asked.of) {
            return None;
        }
        let (open, waiting): (Vec<Excess>, Vec<Excess>) = (-REACH..=REACH).partition(|excess| window.is_open(*excess));
        let first = *open.first()?;
        // What is full by more than the bound has gone past it.
        let fills =
            |from: &Excess| window.next(&[*from], closed, true).iter().all(|to| to > from && !window.is_past(*to));
        let mut waiting = waiting.into_iter().filter(|excess| -REACH < *excess && *excess < first).peekable();
        if waiting.peek().is_none() || !waiting.all(|excess| fills(&excess)) {
            return None;
        }
        let opens = self.search.graph.node(at).next.iter().find(|next| **next != closed)?;
        let then = window.next(&open, *opens, false);
        if then.iter().all(|excess| window.is_open(*excess)) {
            return Some(Gate::Startup);
        }
        let elsewhere = self.reached(|node, _| node != at);
        let is_behind = |node: NodeId| !elsewhere[node.0 as usize] && !way.nodes.contains(&node);
        let takes = |node: NodeId| {
            matches!(window.change(node), Some(Some(Resized::Shrinks(_) | Resized::HeldAt(_) | Resized::Emptied)))
        };
        let is_rate =
            self.nodes().filter(|node| takes(*node)).all(is_behind) && !then.iter().any(|to| window.is_past(*to));
        is_rate.then_some(Gate::Rate)
    }

    /// Whether a function that the cycle does not read here changes a collection.
    fn is_resized_elsewhere(&self, place: &Place) -> bool {
        self.taken_back_by(place, &|_, _| true) != super::passed::TakenBack::Never
    }
}

/// A collection whose length is asked for.
struct Window<'g, 's, 'a> {
    gates: &'g Gates<'s, 'a>,
    asked: &'g AskedLength,
    at: NodeId,
    /// The node behind the answer with which the filter does not run.
    closed: NodeId,
    way: &'g Way,
}

impl Window<'_, '_, '_> {
    /// Whether all that changes the collection in the region is known.
    fn is_followed(&self) -> bool {
        let is_bound_kept = match &self.asked.bound {
            LengthBound::Held(place) => self.gates.is_setting(place),
            LengthBound::Number(_) | LengthBound::Constant(_) => true,
        };
        is_bound_kept
            && !self.gates.calls_write(&self.asked.of)
            && self.gates.nodes().all(|node| self.change(node) != Some(None))
    }

    /// What a node does to the length: nothing at all, or what is known of it.
    fn change(&self, node: NodeId) -> Option<Option<Resized>> {
        let graph = self.gates.search.graph;
        let (Effect::Write(write) | Effect::Set(write)) = &graph.node(node).effect else { return None };
        let aliases = self.gates.search.aliases;
        let is_it = |place: &Place| place.overlaps(&self.asked.of) && place.steps.len() <= self.asked.of.steps.len();
        let concerns = is_it(&write.place) || aliases.shared_roots(&write.place).iter().any(is_it);
        concerns.then(|| graph.resized.get(&node).copied())
    }

    /// What a bound has more than the one that is asked for.
    fn above(&self, bound: &LengthBound) -> Option<Excess> {
        match (bound, &self.asked.bound) {
            (LengthBound::Number(one), LengthBound::Number(other)) => {
                Some(i64::try_from(*one).ok()? - i64::try_from(*other).ok()?)
            }
            (one, other) => (one == other).then_some(0),
        }
    }

    /// The answers that a comparison may have.
    fn answers(&self, asked: &AskedLength, excess: Excess) -> Vec<bool> {
        let Some(bound) = self.above(&asked.bound) else { return vec![true, false] };
        let holds = |excess: Excess| match asked.op {
            "<" => excess < bound,
            "<=" => excess <= bound,
            ">" => excess > bound,
            ">=" => excess >= bound,
            "==" => excess == bound,
            _ => excess != bound,
        };
        let possible: &[Excess] = match excess {
            REACH => &[REACH, REACH + 1],
            low if low == -REACH => &[-REACH, -REACH - 1],
            _ => &[excess],
        };
        if bound.abs() > REACH && excess.abs() == REACH {
            return vec![true, false];
        }
        let answers: BTreeSet<bool> = possible.iter().map(|excess| holds(*excess)).collect();
        answers.into_iter().collect()
    }

    /// Whether the filter runs with such a length, whatever else.
    fn is_open(&self, excess: Excess) -> bool {
        self.ways(self.at, excess).iter().all(|next| *next != self.closed)
    }

    /// Whether the gate is closed with a length that is greater than one with which it is open.
    fn is_past(&self, excess: Excess) -> bool {
        !self.is_open(excess) && (-REACH..excess).any(|less| self.is_open(less))
    }

    /// Where a node leads with such a length.
    fn ways(&self, node: NodeId, excess: Excess) -> Vec<NodeId> {
        let graph = self.gates.search.graph;
        let next = &graph.node(node).next;
        let (Effect::Branch(test), [yes, no]) = (&graph.node(node).effect, next.as_slice()) else {
            return next.clone();
        };
        match test.about.length.as_deref().filter(|asked| asked.of == self.asked.of) {
            Some(asked) => {
                let answers = self.answers(asked, excess).into_iter();
                answers.map(|answer| if answer != test.about.is_turned { *yes } else { *no }).collect()
            }
            None => next.clone(),
        }
    }

    /// The lengths behind a node.
    fn behind(&self, node: NodeId, excess: Excess) -> Vec<Excess> {
        let held = |excess: Excess| excess.clamp(-REACH, REACH);
        let Some(Some(change)) = self.change(node) else { return vec![excess] };
        let lowest = match self.asked.bound {
            LengthBound::Number(number) => i64::try_from(number).map_or(-REACH, |number| held(-number)),
            _ => -REACH,
        };
        match change {
            Resized::Kept => vec![excess],
            Resized::Grows if excess == -REACH => vec![excess, excess + 1],
            Resized::Grows => vec![held(excess + 1)],
            Resized::Shrinks(by) => {
                let less = held(excess - i64::try_from(by).unwrap_or(i64::MAX)).max(lowest);
                if excess == REACH { (less..=REACH).collect() } else { vec![less] }
            }
            Resized::HeldAt(number) => match self.above(&LengthBound::Number(number)) {
                Some(bound) => vec![excess.min(held(bound))],
                None => (-REACH..=excess).collect(),
            },
            Resized::Emptied => vec![lowest],
        }
    }

    /// The lengths with which the next question may come, from such lengths at a node where the filter waits, or runs.
    fn next(&self, from: &[Excess], node: NodeId, waits: bool) -> BTreeSet<Excess> {
        let gates = self.gates;
        let (graph, start) = (gates.search.graph, gates.start());
        let mut asked = BTreeSet::new();
        let mut open: Vec<(NodeId, Excess)> = from.iter().map(|excess| (node, *excess)).collect();
        let mut seen: BTreeSet<(NodeId, Excess)> = BTreeSet::new();
        while let Some((node, excess)) = open.pop() {
            if node == self.at {
                asked.insert(excess);
                continue;
            }
            if !seen.insert((node, excess)) {
                continue;
            }
            let is_inside = |to: NodeId| match gates.region {
                Region::Function => true,
                Region::Loop(id) => to == start || graph.is_within(graph.node(to).in_loop, id),
            };
            // Behind its end a function begins again.
            let ends = gates.region == Region::Function && matches!(graph.node(node).effect, Effect::Return(_));
            let mut next = if ends { vec![start] } else { self.ways(node, excess) };
            // What the answer was kept in says the same: `let is_full = window.len() == 8; if is_full { … }`.
            if node == self.way.at {
                next.retain(|to| (self.way.after(node) == Some(*to)) == waits);
            }
            for length in self.behind(node, excess) {
                open.extend(next.iter().filter(|to| is_inside(**to)).map(|to| (*to, length)));
            }
        }
        asked
    }
}
