//! States that are passed through once: what they wait for is done with when the last one is reached.

use std::collections::BTreeMap;

use super::{Gates, Way};
use crate::count::given::{Given, GivenBase, given};
use crate::count::instances::{inner, place_ty};
use crate::count::summary::Summary;
use crate::flow::{ChangeKind, Effect, Head, NodeId, OTHER_HEADS, Place, Subject, SubjectId};
use crate::index::{FunctionId, Owner, Ty};

/// How many values one behind another are followed to where a state was chosen.
const MAX_COPIES: u32 = 4;

/// Whether something else takes a state back to where the filter pauses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TakenBack {
    Never,
    /// The filter is reset there.
    WithReset,
    /// The filter keeps its state from before.
    Kept,
}

impl Gates<'_, '_> {
    /// Whether a way found a state that the cycle only passes through: `match self.stage { Stage::Level => …, Stage::Still => …,
    /// Stage::Done => filter.update(z) }`.
    pub(super) fn passes_through(&self, way: &Way) -> bool {
        let graph = self.search.graph;
        let mut found: BTreeMap<SubjectId, u32> = BTreeMap::new();
        for (at, next) in way.steps() {
            if let Effect::Branch(test) = &graph.node(*at).effect
                && let Some(id) = test.subject
            {
                let heads = if graph.node(*at).next.first() == Some(next) { test.holds } else { test.fails };
                *found.entry(id).or_insert_with(|| graph.subjects[id.0 as usize].anything()) &= heads;
            }
            if *at == way.at {
                break;
            }
        }
        found.into_iter().any(|(id, heads)| self.is_passed_for_good(id, heads))
    }

    /// `if !ready && !sensor.ok() { continue; } ready = true;`: a condition that is asked until it holds once, for the way from there
    /// to the end raises a flag that nothing takes down.
    pub(super) fn is_let_in(&self, at: NodeId, way: &Way) -> bool {
        let graph = self.search.graph;
        let Some(opens) = graph.node(at).next.iter().find(|next| Some(**next) != way.after(at)).copied() else {
            return false;
        };
        let before = way.nodes.iter().take_while(|node| **node != at);
        before.zip(way.nodes.iter().skip(1)).any(|(asked, next)| {
            let Effect::Branch(test) = &graph.node(*asked).effect else { return false };
            let Some(id) = test.subject else { return false };
            let subject = &graph.subjects[id.0 as usize];
            let Some(place) = subject.whole.as_ref().filter(|place| self.outlives(place)) else { return false };
            let (other, open) = match graph.node(*asked).next.as_slice() {
                [yes, no] if no == next => (*yes, test.holds & !test.fails),
                [yes, no] if yes == next => (*no, test.fails & !test.holds),
                _ => return false,
            };
            let raises = |node: NodeId| match &graph.node(node).effect {
                Effect::Write(write) | Effect::Set(write) if write.place == *place => {
                    write.head.as_ref().is_some_and(|head| subject.bit(head) & open != 0)
                }
                _ => false,
            };
            let mut raised = self.assigning(place).peekable();
            raised.peek().is_some()
                && raised.all(|node| raises(node) && !way.nodes.contains(&node))
                && !self.calls_write(place)
                && !self.reached_from(other, |_, _| true)[at.0 as usize]
                && !self.completes(opens, |node, _| !raises(node))
                && matches!(self.taken_back_elsewhere(subject, place, open), TakenBack::Never)
        })
    }

    /// Whether the cycle moves a state on from these heads to where the filter runs, and neither it nor anything else takes it back
    /// from there.
    fn is_passed_for_good(&self, id: SubjectId, found: u32) -> bool {
        let graph = self.search.graph;
        let subject = &graph.subjects[id.0 as usize];
        let Some(place) = subject.whole.as_ref().filter(|whole| self.copied_from(whole) == **whole) else {
            return false;
        };
        let Some(open) = self.updating(id).filter(|open| found & open == 0) else { return false };
        // What others do with a static is not looked at.
        let is_own = place.base_var().is_some() && self.outlives(place) && self.is_choice(place);
        if !is_own || self.calls_write(place) {
            return false;
        }
        let opens = |head: &Head| subject.bit(head) & open != 0;
        let mut closing: Vec<NodeId> = Vec::new();
        let mut is_opened = false;
        for at in self.nodes() {
            let (Effect::Write(write) | Effect::Set(write)) = &graph.node(at).effect else { continue };
            if write.place == *place {
                for (given_at, head) in self.given_through(at, place, 0) {
                    match head {
                        Some(head) if opens(head) => is_opened = true,
                        _ => closing.push(given_at),
                    }
                }
            } else if !write.rebinds && write.place.overlaps(place) && write.place.steps.len() < place.steps.len() {
                return false;
            }
        }
        let is_passed = is_opened
            && !self.closes_again(id, open, &closing)
            && self.taken_back_elsewhere(subject, place, open) == TakenBack::Never;
        if is_passed {
            let opening = subject.heads.iter().filter(|head| opens(head)).cloned().collect();
            self.own_states.borrow_mut().insert(place.clone(), opening);
        }
        is_passed
    }

    /// The heads that a node gives a state, each with the node at which it was chosen: `stage = match stage { … }`. What leaves the state
    /// as it is found gives it none.
    fn given_through(&self, at: NodeId, state: &Place, copies: u32) -> Vec<(NodeId, Option<&Head>)> {
        let graph = self.search.graph;
        let (Effect::Write(write) | Effect::Set(write)) = &graph.node(at).effect else { return vec![(at, None)] };
        if write.head.is_some() {
            return vec![(at, write.head.as_ref())];
        }
        let Some(from) = graph.copied(at).filter(|_| copies < MAX_COPIES) else { return vec![(at, None)] };
        if self.copied_from(&from) == *state {
            return Vec::new();
        }
        let chosen: Vec<NodeId> = self.assigning(&from).collect();
        if self.outlives(&from) || chosen.is_empty() || self.calls_write(&from) {
            return vec![(at, None)];
        }
        chosen.into_iter().flat_map(|at| self.given_through(at, state, copies + 1)).collect()
    }

    /// Whether an iteration that finds a state open comes to a node that closes it.
    fn closes_again(&self, id: SubjectId, open: u32, closing: &[NodeId]) -> bool {
        let graph = self.search.graph;
        let bits = (0..graph.subjects[id.0 as usize].heads.len()).map(|number| 1_u32 << number).chain([OTHER_HEADS]);
        bits.filter(|bit| open & bit != 0).any(|bit| {
            let reached = self.reached(|node, edge| match &graph.node(node).effect {
                Effect::Branch(other) if other.subject == Some(id) => {
                    (if edge == 0 { other.holds } else { other.fails }) & bit != 0
                }
                _ => true,
            });
            closing.iter().any(|node| reached[node.0 as usize])
        })
    }

    /// Whether a function that the cycle does not read here gives the state, or that of another value of its owner's type, a head
    /// with which the filter pauses: `fn recalibrate(&mut self)`.
    pub(super) fn taken_back_elsewhere(&self, subject: &Subject, place: &Place, open: u32) -> TakenBack {
        self.taken_back_by(place, &|head, _| head.is_none_or(|head| subject.bit(head) & open == 0))
    }

    /// The same where it is told what takes it back: the head that it is given, and how that goes on from the one before.
    pub(super) fn taken_back_by(
        &self,
        place: &Place,
        takes_back: &dyn Fn(Option<&str>, Option<ChangeKind>) -> bool,
    ) -> TakenBack {
        let search = self.search;
        let (index, graph) = (search.program.index, search.graph);
        // The types of all owners on the way to the state, with the steps from there.
        let owners: Vec<(Ty, &[_])> = (0..place.steps.len())
            .filter_map(|count| {
                let (way, rest) = place.steps.split_at(count);
                let owner = Place { base: place.base, steps: way.into() };
                Some((inner(&place_ty(index, graph, &owner)?), rest))
            })
            .collect();
        let is_own = |function: FunctionId| {
            let body = index.function(function).function.body.as_ref();
            function == graph.function
                || body.is_some_and(|body| {
                    let whole = body.expr(body.root).span;
                    self.assigning(place).any(|id| whole.contains(graph.node(id).span))
                })
        };
        let ty_of = |function: FunctionId, param: usize| {
            let def = index.function(function);
            let types = &def.function.params;
            let at = if def.function.receiver.is_some() { param.checked_sub(1) } else { Some(param) };
            match at {
                None => match def.owner {
                    Owner::Impl(of) => Some(index.impl_def(of).self_ty.clone()),
                    _ => None,
                },
                Some(at) => types.get(at).map(|ty| index.lower(ty, &index.scope_of(function))),
            }
        };
        let is_same = |ty: &Ty, owner: &Ty| match (ty, owner) {
            (Ty::Adt(one, _), Ty::Adt(other, _)) => one == other,
            _ => ty == owner,
        };
        let closes = |function: FunctionId, (set, head, change): &(Given, Option<Head>, Option<ChangeKind>)| {
            let GivenBase::Param(param) = set.base else { return false };
            let is_closing = takes_back(head.as_deref(), *change);
            let leads = |(owner, rest): &(Ty, &[_])| {
                (set.steps.starts_with(rest) || rest.starts_with(&set.steps))
                    && ty_of(function, param).is_none_or(|ty| is_same(&inner(&ty), owner))
            };
            is_closing && owners.iter().any(leads)
        };
        let filter = given(graph, search.instance);
        let resets = |summary: &Summary| {
            let mut ways = summary.outcomes(search.law).filter(|(given, _)| Some(*given) == filter.as_ref());
            // Who replaces the owner replaces the filter.
            let is_owner = |set: &Given| {
                let filter = filter.as_ref().filter(|filter| filter.base == set.base);
                filter.is_some_and(|filter| filter.steps.starts_with(&set.steps))
            };
            ways.any(|(_, ways)| ways.iter().all(|way| way.reset)) || summary.sets.iter().any(|(set, ..)| is_owner(set))
        };
        let closing = search.summaries.of.iter().filter(|(function, summary)| {
            !is_own(**function)
                && !index.function(**function).is_test
                && summary.sets.iter().any(|set| closes(**function, set))
        });
        closing.fold(TakenBack::Never, |before, (_, summary)| match before {
            TakenBack::Kept => TakenBack::Kept,
            _ if resets(summary) => TakenBack::WithReset,
            _ => TakenBack::Kept,
        })
    }
}
