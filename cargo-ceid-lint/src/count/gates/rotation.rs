//! States that go round by themselves: `phase = phase.next(); match phase { Phase::A => f.update(z), … }`.

use std::collections::{BTreeMap, BTreeSet};

use super::Gates;
use crate::count::search::Region;
use crate::flow::{Effect, Head, NodeId, Place, SubjectId, Test};

/// How many states are followed for one iteration; beyond that nothing is said.
const MAX_STATES: usize = 4096;

/// What is known of the states that an iteration has to do with.
type Known = BTreeMap<Place, Head>;

impl Gates<'_, '_> {
    /// Whether each iteration leads from one head of a state to the one that follows it, until the filter's turn comes again.
    pub(super) fn rotates(&self, test: &Test) -> bool {
        let graph = self.search.graph;
        let Some(id) = test.subject else { return false };
        let subject = &graph.subjects[id.0 as usize];
        let Some(place) = &subject.whole else { return false };
        let Some(heads) = subject.total.clone().or_else(|| self.written_heads(place)) else { return false };
        if !self.outlives(place) || heads.len() < 2 || self.assigning(place).next().is_none() {
            return false;
        }
        let mut follows: BTreeMap<&Head, Turn> = BTreeMap::new();
        for head in &heads {
            let Some(turn) = self.turn(place, head) else { return false };
            follows.insert(head, turn);
        }
        // From each head on, all heads have their turn.
        let mut seen = BTreeSet::new();
        let mut at = &heads[0];
        while seen.insert(at) {
            let Some(turn) = follows.get(at) else { return false };
            at = &turn.next;
        }
        seen.len() == heads.len() && at == &heads[0] && follows.values().any(|turn| turn.updates)
    }

    /// Whether a count begins anew by itself where it has come to an end, whatever is asked of it besides:
    /// `if turn == 1 { f.update(x); } turn += 1; if turn >= 3 { turn = 0; }`.
    pub(super) fn goes_round(&self, place: &Place, at: NodeId) -> bool {
        let graph = self.search.graph;
        // Each iteration asks for the end, and for nothing else with it.
        let is_end = |branch: NodeId| match &graph.node(branch).effect {
            Effect::Branch(test) => {
                let asks_it = test.about.reads == [place.clone()] && !test.about.is_remainder && !test.about.is_masked;
                asks_it && branch != at && !self.completes(self.start(), |node, _| node != branch)
            }
            _ => false,
        };
        let begins_at_end = |id: NodeId| {
            let leading = self.leading_to(id).unwrap_or_default();
            !leading.is_empty() && leading.iter().all(|(branch, _)| is_end(*branch))
        };
        let mut set_back = self.assigning(place).filter(|id| self.is_set_back(*id, place)).peekable();
        set_back.peek().is_some() && set_back.all(begins_at_end)
    }

    /// Whether it is asked what an iterator gives that begins anew at its end: `let mut lanes = (0..4).cycle(); … lanes.next()`.
    pub(super) fn draws_in_turn(&self, test: &Test) -> bool {
        let sources = self.behind(test);
        let goes_round = |place: &Place| {
            let made_by = place.base_var().and_then(|var| self.search.graph.computed.get(&var));
            self.outlives(place) && made_by.is_some_and(|made_by| made_by.calls.iter().any(|call| call == "cycle"))
        };
        sources.calls.iter().any(|call| call == "next") && sources.places.iter().any(goes_round)
    }

    /// The heads that a number has, where nothing gives it others: `match turn { 0 => turn = 1, 1 => { f.update(x); turn = 2 } _ => turn = 0 }`.
    fn written_heads(&self, place: &Place) -> Option<Vec<Head>> {
        if !self.is_number(place) || self.calls_write(place) {
            return None;
        }
        let mut heads = BTreeSet::new();
        for id in self.assigning(place) {
            match &self.search.graph.node(id).effect {
                Effect::Set(set) | Effect::Write(set) => heads.insert(set.head.clone()?),
                _ => return None,
            };
        }
        Some(heads.into_iter().collect())
    }

    /// What an iteration does that begins with a head of a state; `None` if it may lead to several.
    fn turn(&self, place: &Place, head: &Head) -> Option<Turn> {
        let graph = self.search.graph;
        let updates: BTreeSet<NodeId> = self.search.updating().into_iter().collect();
        let start = self.start();
        let mut turn: Option<Turn> = None;
        let mut does_update = false;
        let mut seen: BTreeSet<(NodeId, Known)> = BTreeSet::new();
        let mut open = vec![(start, Known::from([(place.clone(), head.clone())]))];
        while let Some((id, mut known)) = open.pop() {
            if !seen.insert((id, known.clone())) {
                continue;
            }
            if seen.len() > MAX_STATES {
                return None;
            }
            does_update |= updates.contains(&id);
            self.learn(id, &mut known);
            let node = graph.node(id);
            let is_end = matches!((&node.effect, self.region), (Effect::Return(_), Region::Function));
            let mut ends = is_end;
            for (edge, next) in node.next.iter().enumerate() {
                if !self.can_take(id, edge, &known) {
                    continue;
                }
                match self.region {
                    Region::Loop(_) if *next == start => ends = true,
                    _ if self.is_inside(*next) => open.push((*next, known.clone())),
                    _ => {}
                }
            }
            if ends {
                let next = known.get(place)?.clone();
                if turn.as_ref().is_some_and(|turn| turn.next != next) {
                    return None;
                }
                turn = Some(Turn { next, updates: false });
            }
        }
        turn.map(|turn| Turn { updates: does_update, ..turn })
    }

    /// Whether a branch can go on by an edge, as far as is known of what it asks.
    fn can_take(&self, id: NodeId, edge: usize, known: &Known) -> bool {
        let graph = self.search.graph;
        let Effect::Branch(test) = &graph.node(id).effect else { return true };
        let Some(SubjectId(number)) = test.subject else { return true };
        let subject = &graph.subjects[number as usize];
        let head = subject.whole.as_ref().and_then(|whole| known.get(whole));
        head.is_none_or(|head| (if edge == 0 { test.holds } else { test.fails }) & subject.bit(head) != 0)
    }

    /// What is known behind a node.
    fn learn(&self, id: NodeId, known: &mut Known) {
        let graph = self.search.graph;
        match &graph.node(id).effect {
            Effect::Set(set) | Effect::Write(set) => {
                let copied = graph.copied(id).and_then(|from| known.get(&from).cloned());
                let head = set.head.clone().or(copied);
                let is_it = |place: &Place| {
                    place.overlaps(&set.place)
                        || self.search.aliases.shared_roots(&set.place).iter().any(|root| place.overlaps(root))
                };
                known.retain(|place, _| set.rebinds && *place != set.place || !is_it(place));
                known.extend(head.map(|head| (set.place.clone(), head)));
            }
            Effect::Call(site) => {
                for written in self.written_by(site) {
                    known.retain(|place, _| !place.overlaps(&written));
                }
            }
            Effect::Unknown { places, .. } => {
                known.retain(|place, _| !places.iter().any(|other| other.overlaps(place)));
            }
            _ => {}
        }
    }
}

/// What an iteration does that begins with a head of a state.
struct Turn {
    /// The head with which it ends.
    next: Head,
    /// Whether it may update.
    updates: bool,
}
