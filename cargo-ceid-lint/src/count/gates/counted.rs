//! Counts that are asked for a number that they come to: once, where they stop there, or again and again, where they come round.

use super::passed::TakenBack;
use super::rate::CountSteps;
use super::{Gates, Way};
use crate::flow::{ChangeKind, NodeId, OTHER_HEADS, Place, Tally, Test};

impl Gates<'_, '_> {
    /// `let is_warm = self.rounds >= 50; if is_warm { … } else { self.rounds += 1; }`: a count to a limit whose answer has a name, or is
    /// what a helper gives that counts. It goes on between the two questions, or behind the second one, and nothing else changes it.
    pub(super) fn is_told_warm_up(&self, (origin, chosen_at): (&Test, NodeId), at: NodeId, way: &Way) -> bool {
        let graph = self.search.graph;
        let Some(closed) = way.after(chosen_at) else { return false };
        self.asked(origin).iter().any(|place| {
            if !origin.about.is_comparison {
                return self.outlives(place) && self.is_counted_up_to(origin, chosen_at, place, way);
            }
            let side = origin.about.compared.iter().position(|side| side.as_ref() == Some(place));
            let is_below = side.and_then(|side| graph.node(chosen_at).next.get(side)).map(|below| *below == closed);
            let goes_by = |node: NodeId, _: usize| !self.counts_at(node, place);
            let counts =
                || !self.reached_from(closed, goes_by)[at.0 as usize] || self.counts_while_closed(place, at, way);
            self.outlives(place)
                && self.is_number(place)
                && self.count_steps(place).is_some_and(|steps| {
                    steps.is_one_way() && !steps.set_back && !steps.wraps && is_below == Some(steps.up)
                })
                && counts()
                && !self.comes_round(place)
                && !self.is_set_elsewhere(place)
        })
    }

    /// `if self.n < FULL { self.n += 1; } if self.n == FULL { … }`, `self.n = (self.n + 1).min(FULL)`: a count that stops at the number
    /// which is asked for, goes on in each cycle that waits for that, and is never set back.
    pub(super) fn is_counted_up_to(&self, test: &Test, at: NodeId, place: &Place, way: &Way) -> bool {
        let graph = self.search.graph;
        let Some(full) = self.opens_at(test, at, place, way) else { return false };
        let tally = |id: NodeId| graph.changes.get(&id).and_then(|change| change.tally).filter(|tally| tally.up);
        let is_held = |id: NodeId| tally(id).is_some_and(|tally| tally.held_at == Some(full));
        // The answer with which a count goes on: it is below the number.
        let below = |id: NodeId| {
            let (asked, branch) = self.branch_before(id).filter(|_| tally(id).is_some_and(|tally| tally.step == 1))?;
            let side = asked.about.compared.iter().position(|side| side.as_ref() == Some(place))?;
            let below = *graph.node(branch).next.get(side)?;
            let leads = self.reached_from(below, |node, _| node != branch)[id.0 as usize];
            (asked.about.is_comparison && asked.about.numbers == [full] && leads).then_some((branch, side))
        };
        let counting: Vec<NodeId> = self.assigning(place).collect();
        let stopping: Vec<(NodeId, usize)> = counting.iter().filter_map(|id| below(*id)).collect();
        let stops = |id: NodeId| is_held(id) || below(id).is_some();
        let goes_by = |node: NodeId, edge: usize| {
            !counting.contains(&node) && !stopping.iter().any(|(branch, side)| *branch == node && *side != edge)
        };
        !counting.is_empty()
            && counting.iter().all(|id| stops(*id))
            && !self.calls_write(place)
            && !self.reached(goes_by)[at.0 as usize]
            && !self.is_set_elsewhere(place)
    }

    /// Whether a comparison waits until a count has come to a number, once: it goes on in each cycle that waits for it.
    pub(super) fn is_warmed_up(&self, test: &Test, at: NodeId, place: &Place, way: &Way, steps: CountSteps) -> bool {
        let counts_on = self.counts_while_closed(place, at, way);
        // What counts up opens where it is large, what counts down where it is small.
        let opens = self.waits_below(test, at, place).is_none_or(|below| below == steps.up);
        let is_for_good = !self.comes_round(place);
        steps.is_one_way() && test.about.is_comparison && counts_on && opens && is_for_good
    }

    /// `if n < FULL { n += 1; if x > LIMIT { n = 0; } continue; }`: a count that begins anew only while it is not done.
    pub(super) fn is_begun_anew_while_closed(&self, place: &Place, at: NodeId, way: &Way) -> bool {
        let Some(closed) = way.after(at) else { return false };
        let goes_past = |node: NodeId, edge: usize| {
            node != at || self.search.graph.node(node).next.get(edge).is_some_and(|next| *next != closed)
        };
        let otherwise = self.reached(goes_past);
        let is_closed = |node: NodeId| !otherwise[node.0 as usize];
        let sets_back = |id: &NodeId| self.is_set_back(*id, place);
        self.assigning(place).filter(sets_back).all(is_closed)
            && !self.calls_write(place)
            && !self.is_set_elsewhere(place)
    }

    /// `tick = tick.wrapping_add(1); if tick == 0 { … }`: a number of a small type, which comes to each of its values again.
    pub(super) fn comes_round_to(&self, test: &Test, at: NodeId, place: &Place, way: &Way) -> bool {
        let graph = self.search.graph;
        let Some(asked) = self.opens_at(test, at, place, way) else { return false };
        let comes_to = |tally: Tally| tally.step > 0 && asked % (1 << tally.step.trailing_zeros()) == 0;
        let comes_round = |id: NodeId| {
            let change = graph.changes.get(&id).filter(|change| change.goes_round);
            change.is_some_and(|change| {
                let is_step = matches!(change.kind, ChangeKind::CountsUp | ChangeKind::CountsDown);
                is_step && change.tally.is_some_and(comes_to)
            })
        };
        let mut counting = self.assigning(place).peekable();
        counting.peek().is_some() && counting.all(comes_round) && !self.calls_write(place)
    }

    /// The only number of a place with which a way does not go past the update, if that is what a condition asks for.
    fn opens_at(&self, test: &Test, at: NodeId, place: &Place, way: &Way) -> Option<u64> {
        let graph = self.search.graph;
        let whole = graph.subjects[test.subject?.0 as usize].whole.as_ref();
        let ([yes, no], [head]) = (graph.node(at).next.as_slice(), test.about.heads.as_slice()) else { return None };
        let closed = way.after(at)?;
        let (open, closing) =
            if closed == *no && closed != *yes { (test.holds, test.fails) } else { (test.fails, test.holds) };
        let number = head.parse().ok()?;
        let is_it = whole == Some(place) && self.is_number(place) && !test.about.is_comparison;
        let bit = graph.subjects[test.subject?.0 as usize].bit(head);
        (is_it && bit != OTHER_HEADS && open == bit && closing & bit == 0).then_some(number)
    }

    /// Whether a function that the cycle does not read here gives a count another number, so that it does not go on from there.
    fn is_set_elsewhere(&self, place: &Place) -> bool {
        let sets = |_: Option<&str>, change: Option<ChangeKind>| !change.is_some_and(ChangeKind::counts);
        self.taken_back_by(place, &sets) != TakenBack::Never
    }
}
