//! Copies that go back to the instance's place. Each way says at the copy whether it puts it back, and is not taken where it does
//! otherwise: `let mut next = self.lag; next.update(x); if is_good() { self.lag = next; }`

use super::run::Run;
use super::{Region, Search, State};
use crate::flow::{Assignment, CallSite, Effect, IndexKey, LoopId, NodeId, Place, Projection, Relation, Transfer, Var};
use crate::index::Ty;

/// What a way has said of copies.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Copies {
    /// The names that the instance gets back where the copy is put back in which it goes on. None of them are left at an end.
    awaited: Vec<Place>,
    /// The copies that are left alone: where one of them is put back, the way is another one.
    others: Vec<Place>,
}

impl Copies {
    /// Whether the instance stays in its place, and what is done to a copy of it is lost.
    fn are_lost(&self) -> bool {
        self.awaited.is_empty() && !self.others.is_empty()
    }
}

impl Search<'_> {
    /// Whether a node puts a copy back that the instance may go on in.
    fn puts_back(&self, node: NodeId) -> bool {
        match &self.graph.node(node).effect {
            Effect::Set(set) | Effect::Write(set) => {
                set.from.is_some()
                    && set.transfer != Transfer::Copy
                    && self.aliases.shared_roots(&set.place).iter().any(|root| root.overlaps(self.instance))
            }
            _ => false,
        }
    }

    /// From where a copy can still be put back, or an update be reached. Empty where no copy is ever put back.
    pub(super) fn reach_of_copies(&self, region: Region) -> Vec<bool> {
        let back: Vec<NodeId> = self.near().filter(|node| self.puts_back(*node)).collect();
        if back.is_empty() { Vec::new() } else { self.reach_to(region, back) }
    }

    /// Whether a copy is put back in a loop or behind it.
    pub(super) fn is_put_back_from(&self, head: NodeId) -> bool {
        let back: Vec<NodeId> = self.near().filter(|node| self.puts_back(*node)).collect();
        !back.is_empty() && {
            let reached = self.reached_from(Region::Function, head, |_, _| true);
            back.iter().any(|node| reached[node.0 as usize])
        }
    }
}

impl Run<'_, '_> {
    /// The ways behind an assignment of a copy that may go back to where it is from: the instance goes along with it, or stays.
    pub(super) fn copied(&mut self, state: &State, set: &Assignment) -> Vec<(State, Assignment)> {
        let Some(from) = &set.from else { return vec![(state.clone(), set.clone())] };
        let set = &Assignment { place: self.numbered(state, &set.place), ..set.clone() };
        let names = self.names.get(state.names).clone();
        let Copies { awaited, others } = self.copies.get(state.copies).clone();
        let value = |var: Var| self.number(state, var);
        let carried = |place: &Place| match from.relate(place, &value) {
            Relation::Holds(rest) => Some(set.place.join(&rest)),
            _ => None,
        };
        let put: Vec<Place> = others.iter().filter_map(carried).collect();
        if put.iter().any(|place| names.contains(place)) {
            return Vec::new();
        }
        let is_over = |place: &Place| matches!(set.place.relate(place, &value), Relation::Holds(_));
        let others = joined(others.into_iter().filter(|place| !is_over(place)).collect(), put);
        let left: Vec<Place> = names.iter().filter(|name| carried(name).is_some()).cloned().collect();
        let given: Vec<Place> = left.iter().filter_map(carried).collect();
        if given.is_empty() {
            let copies = self.copies.intern(Copies { awaited, others });
            return vec![(State { copies, ..state.clone() }, set.clone())];
        }
        // A value without a name is not asked for again.
        let is_unnamed = |place: &Place| {
            let info = place.base_var().map(|var| self.search.graph.var(var));
            info.is_some_and(|info| info.name.is_empty() && !matches!(info.ty, Ty::Ref(..) | Ty::Unknown))
        };
        let is_moved = set.transfer != Transfer::RoundTrip || left.iter().all(is_unnamed);
        if is_moved && awaited.is_empty() {
            let copies = self.copies.intern(Copies { awaited, others });
            return vec![(State { copies, ..state.clone() }, set.clone())];
        }
        // What was moved out of its place is put back there, unless it goes on where it is in the next iteration.
        let is_out = awaited.is_empty()
            && given.contains(self.search.instance)
            && !left.iter().all(|place| self.search.outlives(self.region, place));
        let awaited = if is_out { vec![self.search.instance.clone()] } else { awaited };
        let beside = joined(others.clone(), given.clone());
        let staying = self.copies.intern(Copies { awaited: awaited.clone(), others: beside });
        let stays = Assignment { transfer: Transfer::Copy, ..set.clone() };
        let mut ways = vec![(State { copies: staying, ..state.clone() }, stays)];
        // What is moved is no longer where it was.
        if is_moved {
            ways.clear();
        }
        ways.push((self.going_along(state, set, left, Copies { awaited, others }), set.clone()));
        ways
    }

    /// The state in which the instance goes along with an assignment, out of its place or back there.
    fn going_along(&mut self, state: &State, set: &Assignment, left: Vec<Place>, copies: Copies) -> State {
        let names = self.names.get(state.names).clone();
        let Copies { awaited, others } = copies;
        let given: Vec<Place> = left
            .iter()
            .filter_map(|name| match set.from.as_ref()?.relate(name, &|var| self.number(state, var)) {
                Relation::Holds(rest) => Some(set.place.join(&rest)),
                _ => None,
            })
            .collect();
        let back = awaited.iter().find(|place| given.iter().any(|given| self.in_round(state, place).contains(given)));
        let mut next = state.clone();
        let (awaited, others) = match back {
            _ if awaited.is_empty() => {
                let is_there = names.contains(self.search.instance);
                (joined(left, if is_there { Vec::new() } else { vec![self.search.instance.clone()] }), others)
            }
            Some(_) if set.transfer == Transfer::Borrow => (Vec::new(), others),
            None if set.transfer == Transfer::Borrow => (awaited, others),
            // Each element of the copy is put back in its own round.
            Some(place) if !given.contains(place) => {
                let (old, mut kept): (Vec<Place>, Vec<Place>) = names
                    .into_iter()
                    .partition(|name| self.in_round(state, name).iter().any(|name| left.contains(name)));
                kept.push(place.clone());
                next.names = self.names.intern(joined(kept, left));
                (Vec::new(), joined(others, old))
            }
            Some(_) => (Vec::new(), joined(others, left)),
            None => (awaited, joined(others, left)),
        };
        next.copies = self.copies.intern(Copies { awaited, others });
        next
    }

    /// A place, its elements by the numbers that counters have at hand.
    fn numbered(&self, state: &State, place: &Place) -> Place {
        let numbered = |step: &Projection| match step.key() {
            Some(IndexKey::Var(var)) => match self.number(state, *var) {
                Some(number) => step.with_key(IndexKey::Number(number)),
                None => step.clone(),
            },
            _ => step.clone(),
        };
        Place { base: place.base, steps: place.steps.iter().map(numbered).collect() }
    }

    /// A place, with its names in the rounds at hand of loops over what it is an element of.
    fn in_round(&self, state: &State, place: &Place) -> Vec<Place> {
        let around = self.search.graph.loops_around(state.node).take_while(|id| self.region != Region::Loop(*id));
        around
            .filter(|id| self.search.covers(*id))
            .fold(vec![place.clone()], |names, id| self.search.with_items(&names, id))
    }

    /// The copies under the names that they have behind an assignment that puts none of them back.
    pub(super) fn copies_behind(&mut self, state: &State, set: &Assignment) -> u32 {
        let Copies { awaited, others } = self.copies.get(state.copies);
        if others.is_empty() {
            return state.copies;
        }
        let (awaited, others) = (awaited.clone(), others.clone());
        let others = self.search.renamed(&others, set, state.node, &|var| self.number(state, var)).0;
        self.copies.intern(Copies { awaited, others })
    }

    /// The copies under the names that they have behind a call, which may give back what it gets.
    pub(super) fn copies_through(&mut self, state: &State, site: &CallSite) -> u32 {
        let Copies { awaited, others } = self.copies.get(state.copies);
        if others.is_empty() {
            return state.copies;
        }
        match self.search.borrowed(others, site, &|var| self.number(state, var)) {
            Some((others, _)) => {
                let awaited = awaited.clone();
                self.copies.intern(Copies { awaited, others })
            }
            None => state.copies,
        }
    }

    /// The copies in another round of a loop, its own one or not; `None` if one that was made in the round before was to be put back.
    pub(super) fn copies_in_round(&mut self, copies: u32, id: LoopId, is_own: bool) -> Option<u32> {
        let Copies { awaited, others } = self.copies.get(copies);
        if awaited.is_empty() && others.is_empty() {
            return Some(copies);
        }
        let (awaited, others) = (awaited.clone(), others.clone());
        if self.search.without_items(&awaited, id).len() < awaited.len() {
            return None;
        }
        let others = self.search.without_items(&others, id);
        let others = if is_own { self.search.with_items(&others, id) } else { others };
        Some(self.copies.intern(Copies { awaited, others }))
    }

    /// Whether a way has said anything of copies.
    pub(super) fn has_copies(&self, state: &State) -> bool {
        *self.copies.get(state.copies) != Copies::default()
    }

    /// Whether a way ends that was to put a copy back.
    pub(super) fn awaits_copy(&self, state: &State) -> bool {
        !self.copies.get(state.copies).awaited.is_empty()
    }

    /// Whether a way loses what is done to a copy.
    pub(super) fn loses_copy(&self, state: &State) -> bool {
        self.copies.get(state.copies).are_lost()
    }
}

fn joined(mut places: Vec<Place>, more: Vec<Place>) -> Vec<Place> {
    places.extend(more);
    places.sort();
    places.dedup();
    places
}
