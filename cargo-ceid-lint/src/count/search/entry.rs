//! Where a search of a loop begins: the names that the instance has there, and what is known of conditions.

use super::copies::Copies;
use super::interner::Interner;
use super::names::is_concerned;
use super::run::Run;
use super::{MAX_STATES, Region, Search, State};
use crate::count::counts::Count;
use crate::flow::{Base, Cause, Effect, LoopId, NodeId, Place, Subject, Transfer};
use std::collections::BTreeSet;

use rustc_hash::FxHashSet;

/// A node at which a search begins, with the names that the instance has there, or its own name.
pub(in crate::count) type Start = (NodeId, Option<Entry>);

/// What is known where a search begins.
#[derive(Clone, Debug)]
pub(in crate::count) struct Entry {
    pub(in crate::count) names: Vec<Place>,
    /// Why it may have other names, too.
    pub(in crate::count) doubt: Option<Cause>,
}

impl Search<'_> {
    /// The heads that a subject can have where a loop is entered: those of the constants that a variable is given outside it, and
    /// those that the branches on the way there leave.
    pub(super) fn known_before(&self, region: Region, id: crate::flow::SubjectId) -> u32 {
        let graph = self.graph;
        let subject = &graph.subjects[id.0 as usize];
        let (Region::Loop(own), Some(place)) = (region, &subject.whole) else { return subject.anything() };
        let is_local = place.steps.is_empty() && place.base_var().is_some_and(|var| graph.var(var).param.is_none());
        self.dependence.before_loop(own, id, || {
            let given = if is_local { self.given_before(own, subject, place) } else { subject.anything() };
            match given & self.entering(own, id) {
                // Nothing enters it, as far as can be told.
                0 => subject.anything(),
                heads => heads,
            }
        })
    }

    /// Whether a branch asks again what was asked before its loop.
    pub(super) fn was_asked(&self, region: Region, branch: NodeId) -> bool {
        let Effect::Branch(test) = &self.graph.node(branch).effect else { return false };
        test.subject.is_some_and(|id| self.known_before(region, id) != self.graph.subjects[id.0 as usize].anything())
    }

    /// The heads that are given to a variable outside a loop; any, if something else writes it there.
    fn given_before(&self, own: LoopId, subject: &Subject, place: &Place) -> u32 {
        let graph = self.graph;
        let mut heads = 0;
        for node in graph.nodes.iter().filter(|node| !graph.is_within(node.in_loop, own)) {
            let written = match &node.effect {
                Effect::Set(set) | Effect::Write(set) if set.place == *place => match &set.head {
                    Some(head) => {
                        heads |= subject.bit(head);
                        false
                    }
                    None => true,
                },
                Effect::Set(set) | Effect::Write(set) => set.place.overlaps(place),
                Effect::Unknown { places, .. } => places.iter().any(|other| other.overlaps(place)),
                Effect::Call(site) => site.args.iter().any(|arg| {
                    !arg.is_shared
                        && arg.place.as_ref().is_some_and(|other| {
                            self.aliases.shared_roots(other).iter().any(|root| root.overlaps(place))
                        })
                }),
                _ => false,
            };
            if written {
                return subject.anything();
            }
        }
        if heads == 0 { subject.anything() } else { heads }
    }

    /// The names that the instance can have, and what is known, where control reaches a loop's head from outside.
    pub(in crate::count) fn entries(&self, id: LoopId) -> Vec<Entry> {
        let head = self.graph.loop_info(id).head;
        let starts = self.declarations();
        let mut found = Vec::new();
        let mut seen: BTreeSet<Reached> = BTreeSet::new();
        let mut all = self.explore_to(head, &starts, false);
        // What leads there decides over names only where there are several.
        if all.iter().any(|reached| *reached != all[0]) {
            all = self.explore_to(head, &starts, true);
        }
        for reached in all {
            if !self.is_own_round(&reached.0, id) {
                continue;
            }
            let mut reached = reached;
            if reached.0.contains(self.instance) {
                reached.0.extend_from_slice(self.homes());
            }
            if seen.insert(reached.clone()) {
                found.push(Entry { names: reached.0, doubt: reached.1 });
            }
        }
        if found.is_empty() {
            found.push(Entry { names: vec![self.instance.clone()], doubt: None });
        }
        found
    }

    /// Whether a loop is entered in the round of the loops around it that is the instance's own. In the other rounds their items
    /// are other elements.
    fn is_own_round(&self, names: &[Place], id: LoopId) -> bool {
        let graph = self.graph;
        let around = std::iter::successors(graph.loop_info(id).begun_in, |id| graph.loop_info(*id).begun_in);
        around.filter(|id| self.covers(*id)).all(|id| {
            let is_lent = !graph.loop_info(id).items.is_empty() || self.instance.stands_for_each();
            !is_lent || self.without_items(names, id).len() < names.len()
        })
    }

    /// Where the instance begins to exist: the function's entry, or the nodes that give its variable a value.
    fn declarations(&self) -> Vec<NodeId> {
        let Base::Var(var) = self.instance.base else { return vec![NodeId(0)] };
        if self.graph.var(var).param.is_some() {
            return vec![NodeId(0)];
        }
        let nodes: Vec<NodeId> = self
            .graph
            .node_ids()
            .filter(|id| {
                matches!(&self.graph.node(*id).effect, Effect::Set(set)
                    if set.place.steps.is_empty() && set.place.base_var() == Some(var))
            })
            .collect();
        if nodes.is_empty() { vec![NodeId(0)] } else { nodes }
    }

    /// The names of the instance at a node, over all ways that lead there, or over those that conditions which never change leave.
    fn explore_to(&self, target: NodeId, starts: &[NodeId], are_told_apart: bool) -> Vec<Reached> {
        let mut known: Interner<(Reached, Vec<LoopId>)> = Interner::default();
        let mut seen: FxHashSet<(NodeId, u32)> = FxHashSet::default();
        let mut open: Vec<(NodeId, u32)> = Vec::new();
        let begin = known.intern(((vec![self.instance.clone()], None), Vec::new()));
        for start in starts {
            for next in &self.graph.node(*start).next {
                open.push((*next, begin));
            }
            if *start == target {
                return vec![known.get(begin).0.clone()];
            }
        }
        // A long function has many nodes, and few names at each of them.
        let limit = (MAX_STATES / 4).max(4 * self.graph.nodes.len());
        let is_put_back = self.is_put_back_from(target);
        let mut found = Vec::new();
        while let Some((node, reached)) = open.pop() {
            if node == target {
                found.push(known.get(reached).0.clone());
                continue;
            }
            if seen.len() > limit {
                let cause = Cause::Limit("too many paths lead to the cycle".to_owned());
                found.push((vec![self.instance.clone()], Some(cause)));
                break;
            }
            if !seen.insert((node, reached)) {
                continue;
            }
            // Loops over the elements of a collection that have had the round of the instance.
            let ((names, doubt), passed) = known.get(reached);
            let (mut behind, mut passed): (Vec<Reached>, Vec<LoopId>) = (Vec::new(), passed.clone());
            let mut round = None;
            match &self.graph.node(node).effect {
                // What is told of a part of what was just made leaves that where it is.
                Effect::Set(set) if set.is_of_part() => {}
                Effect::Set(set) | Effect::Write(set) if is_concerned(names, set) => {
                    // A copy that was put back by then, or never is, tells nothing.
                    let stays =
                        set.transfer == Transfer::RoundTrip && !is_put_back && !set.place.overlaps(self.instance);
                    let chosen = self.chosen_of(names, set, &|_| None);
                    let chosen = chosen.or_else(|| self.pointed_somewhere(names, set, node, &|_| None));
                    let names = if stays { names.clone() } else { self.pointed_before(names, set, node) };
                    // Where its variable gets another value and nothing else names it, the instance is gone; what its variable
                    // names from there on is followed from there.
                    if names.is_empty() && starts.contains(&node) {
                        continue;
                    }
                    behind.push((names, chosen.or_else(|| doubt.clone())));
                }
                Effect::Call(site) => {
                    if let Some((names, is_doubtful)) = self.borrowed(names, site, &|_| None) {
                        let cause = || Cause::Index(site.text.clone());
                        behind.push((names, if is_doubtful { Some(cause()) } else { doubt.clone() }));
                    }
                }
                Effect::LoopEnter(id) => {
                    behind.push((names.clone(), doubt.clone()));
                    passed.retain(|other| other != id);
                }
                Effect::LoopHead(id) => {
                    let plain = self.without_items(names, *id);
                    if self.covers(*id) && !passed.contains(id) {
                        round = Some((self.with_items(&plain, *id), doubt.clone(), *id));
                    }
                    behind.push((plain, doubt.clone()));
                }
                _ => {}
            }
            let is_due = round.as_ref().is_some_and(|(_, _, id)| !self.passes_over(*id));
            if let (Some((names, doubt, id)), Some(first)) = (round, self.graph.node(node).next.first()) {
                let had = passed.iter().copied().chain([id]).collect();
                open.push((*first, known.intern(((names, doubt), had))));
            }
            let all: Vec<u32> = match behind.is_empty() {
                true => vec![reached],
                false => behind.into_iter().map(|reached| known.intern((reached, passed.clone()))).collect(),
            };
            let asked = match &self.graph.node(node).effect {
                Effect::Branch(test) if are_told_apart => test.subject.map(|id| (test, id)),
                _ => None,
            };
            let possible = asked.map(|(_, id)| self.settled_at(node, id));
            for (edge, next) in self.graph.node(node).next.iter().enumerate() {
                // Each element has its round before the loop comes to its end.
                if is_due && edge > 0 {
                    continue;
                }
                let heads = asked.map_or(0, |(test, _)| if edge == 0 { test.holds } else { test.fails });
                if possible.is_none_or(|possible| possible & heads != 0) {
                    let own = all.iter().filter(|reached| !self.is_of_another(&known.get(**reached).0.0, *next));
                    open.extend(own.map(|reached| (*next, *reached)));
                }
            }
        }
        // To follow names takes less than to follow all that is known of a way.
        self.states.set(self.states.get() + seen.len() / 4);
        found
    }
}

/// Names of the instance, and why it may have others.
type Reached = (Vec<Place>, Option<Cause>);

/// What an iteration begins with.
pub(super) struct Known {
    pub(super) node: NodeId,
    pub(super) age: super::Age,
    pub(super) names: u32,
    pub(super) masks: u32,
    pub(super) rounds: u32,
    /// Why nothing is certain from the beginning on.
    pub(super) doubt: Option<u16>,
}

impl Run<'_, '_> {
    pub(super) fn start(&mut self, node: NodeId, entry: Option<&Entry>) {
        let known = self.tracked.subjects.iter().map(|id| self.search.known_before(self.region, *id));
        let of_caller = self.of_caller.iter().map(|_| super::shared::UNWRITTEN);
        let of_element = self.of_element.iter().map(|own| own.anything(self.search.graph));
        let all: Vec<u32> = known.chain(of_caller).chain(of_element).collect();
        let masks = self.masks.intern(all);
        self.start_with(node, entry, masks, super::Age::default());
    }

    pub(super) fn start_with(&mut self, node: NodeId, entry: Option<&Entry>, masks: u32, age: super::Age) {
        let own = || [self.search.instance].into_iter().chain(self.search.homes()).cloned().collect();
        let names = entry.map_or_else(own, |entry| entry.names.clone());
        let names = self.names.intern(names);
        let rounds = self.rounds.intern(Vec::new());
        if let Some(cause) = entry.and_then(|entry| entry.doubt.as_ref()) {
            self.doubt = Some(self.cause(cause));
        }
        self.begin(Known { node, age, names, masks, rounds, doubt: None });
    }

    /// Begins an iteration: nothing has happened on the way yet.
    pub(super) fn begin(&mut self, known: Known) {
        let Known { node, age, names, masks, rounds, doubt } = known;
        let state = State {
            node,
            count: Count::Zero,
            in_sample: false,
            reset: false,
            direct: false,
            attempted: false,
            unknown: doubt.or(self.doubt),
            is_supposed: doubt.is_some(),
            skipped_at: None,
            helper_gate: None,
            age,
            names,
            versions: self.versions.intern(Vec::new()),
            copies: self.copies.intern(Copies::default()),
            masks,
            rounds,
        };
        self.push(state, None);
    }
}
