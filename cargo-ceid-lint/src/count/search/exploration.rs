//! What a search has found: its states, and how its ways end.

use std::collections::{BTreeMap, BTreeSet};

use super::run::Run;
use super::{Region, Search, Start, State};
use crate::count::assumed::Assumed;
use crate::count::counts::Count;
use crate::count::returned;
use crate::count::slice::{FEW_TRACKED, MAX_TRACKED};
use crate::flow::{Cause, Effect, NodeId, SubjectId};

/// How a way ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::count) enum EndKind {
    /// The next iteration follows.
    Completes,
    /// The loop or function is left for good.
    Exits,
}

/// A way's end.
#[derive(Clone, Debug)]
pub(in crate::count) struct End {
    pub(in crate::count) kind: EndKind,
    pub(in crate::count) state: State,
    /// The number of the state in [`Exploration::states`].
    pub(in crate::count) at: usize,
    pub(in crate::count) returned: returned::Heads,
    /// How far the state that is given back is ahead of the instance.
    pub(in crate::count) ahead: Count,
    /// Whether the instance is in another place that a caller knows, and no longer in its own.
    pub(in crate::count) has_left: bool,
    /// Whether what is done to a copy of it is lost.
    pub(in crate::count) is_copy_lost: bool,
    /// With which conditions of a caller's it is taken, where callers are to know.
    pub(in crate::count) assumed: Assumed,
    /// What is known of those that it has written, by then.
    pub(in crate::count) left: Assumed,
}

/// All ways through a region.
#[derive(Debug, Default)]
pub(in crate::count) struct Exploration {
    pub(in crate::count) states: Vec<State>,
    pub(super) parents: Vec<Option<usize>>,
    /// How many states come before each on its way.
    pub(super) depths: Vec<u32>,
    pub(in crate::count) ends: Vec<End>,
    pub(in crate::count) causes: Vec<Cause>,
    /// Set if the search gave up.
    pub(in crate::count) limit: bool,
    /// Set if ways were left out that say otherwise of a copy than what comes of it.
    pub(in crate::count) leaves_out_copies: bool,
    /// Conditions that could not be told apart, because there are too many.
    pub(super) dropped: Dropped,
}

/// Conditions that were not told apart, with those that are copied from one of them, and the nodes that say something of them.
#[derive(Debug, Default)]
pub(in crate::count) struct Dropped {
    subjects: BTreeSet<SubjectId>,
    given: BTreeMap<NodeId, Vec<SubjectId>>,
    overwritten: BTreeMap<NodeId, Vec<SubjectId>>,
}

impl Exploration {
    /// The state before one on its way.
    pub(in crate::count) fn parent(&self, at: usize) -> Option<usize> {
        self.parents[at]
    }

    /// How long the way to a state is.
    pub(in crate::count) fn depth(&self, at: usize) -> u32 {
        self.depths[at]
    }

    /// The states of the way to one, in order.
    pub(in crate::count) fn path(&self, at: usize) -> Vec<usize> {
        let mut path = vec![at];
        let mut at = at;
        while let Some(parent) = self.parents[at] {
            path.push(parent);
            at = parent;
        }
        path.reverse();
        path
    }
}

impl Search<'_> {
    /// Searches a region.
    pub(in crate::count) fn explore(&self, region: Region, starts: &[Start]) -> Exploration {
        self.explored(region, starts, &|_| ())
    }

    /// Follows all ways, and where they are too many once more with fewer of their conditions told apart: what is so of all of them
    /// is so, and a way that needs more is not certain.
    pub(super) fn explored(&self, region: Region, starts: &[Start], prepare: &dyn Fn(&mut Run<'_, '_>)) -> Exploration {
        let follow = |most: usize| {
            let mut run = self.run(region, most);
            prepare(&mut run);
            let exploration = run.finish(starts);
            self.states.set(self.states.get() + exploration.states.len());
            exploration
        };
        let exploration = follow(MAX_TRACKED);
        // A second update that was found needs no more ways.
        if !exploration.limit || exploration.ends.iter().any(|end| end.state.count == Count::Many) {
            return exploration;
        }
        let fewer = follow(FEW_TRACKED);
        if fewer.limit { exploration } else { fewer }
    }

    /// Whether a way may not exist, for what it asks of conditions that were not told apart: one is to hold and not to hold, or another
    /// than it was given.
    pub(in crate::count) fn asks_dropped(&self, exploration: &Exploration, end: &End) -> bool {
        let Dropped { subjects: dropped, given, overwritten } = &exploration.dropped;
        if dropped.is_empty() {
            return false;
        }
        let path: Vec<NodeId> = exploration.path(end.at).into_iter().map(|at| exploration.states[at].node).collect();
        // The heads that each may have; none where it has some that are not followed.
        let mut known: BTreeMap<SubjectId, Option<u32>> = BTreeMap::new();
        for (number, at) in path.iter().enumerate() {
            let node = self.graph.node(*at);
            for id in overwritten.get(at).into_iter().flatten() {
                known.remove(id);
            }
            for id in given.get(at).into_iter().flatten() {
                let from = self.graph.copied(*at).and_then(|from| self.graph.subject_of(&from));
                let heads = match (&node.effect, from) {
                    (Effect::Set(set) | Effect::Write(set), _) if set.head.is_some() => {
                        let bit = |head: &String| self.graph.subjects[id.0 as usize].bit(head);
                        Some(set.head.as_ref().map(bit))
                    }
                    (_, Some(from)) if dropped.contains(&from) && !known.contains_key(&from) => None,
                    _ => Some(None),
                };
                match heads {
                    Some(heads) => known.insert(*id, heads),
                    None => known.remove(id),
                };
            }
            let Effect::Branch(test) = &node.effect else { continue };
            let Some(id) = test.subject.filter(|id| dropped.contains(id)) else { continue };
            let goes = |answer: usize| path.get(number + 1).is_none_or(|next| node.next.get(answer) == Some(next));
            let asked = [(0, test.holds), (1, test.fails)];
            let asked = asked.iter().filter(|(answer, _)| goes(*answer)).fold(0, |all, (_, heads)| all | heads);
            match known.get(&id) {
                Some(None) => return true,
                Some(Some(heads)) if heads & asked == 0 => return true,
                Some(Some(heads)) => known.insert(id, Some(heads & asked)),
                None => known.insert(id, Some(asked)),
            };
        }
        false
    }
}

impl Run<'_, '_> {
    /// The conditions that were not told apart.
    pub(super) fn untracked(&self) -> Dropped {
        let search = self.search;
        let is_tracked = |id: &SubjectId| self.tracked.subjects.contains(id);
        let mut subjects: BTreeSet<SubjectId> =
            self.tracked.dropped.iter().filter(|id| !is_tracked(id)).copied().collect();
        let mut before = 0;
        while subjects.len() > before {
            before = subjects.len();
            for (id, writers) in &search.dependence.assigned {
                let from = |writer: &NodeId| search.graph.subject_of(&search.graph.copied(*writer)?);
                if writers.iter().filter_map(from).any(|from| subjects.contains(&from)) {
                    subjects.insert(*id);
                }
            }
        }
        let writers = |of: &BTreeMap<SubjectId, Vec<NodeId>>| {
            let mut found: BTreeMap<NodeId, Vec<SubjectId>> = BTreeMap::new();
            for (id, nodes) in of.iter().filter(|(id, _)| subjects.contains(id)) {
                nodes.iter().for_each(|node| found.entry(*node).or_default().push(*id));
            }
            found
        };
        let (given, overwritten) = (writers(&search.dependence.assigned), writers(&search.dependence.overwritten));
        Dropped { subjects, given, overwritten }
    }
}

/// Why a way that passes such conditions is not certain.
pub(in crate::count) fn too_many_conditions() -> Cause {
    Cause::Limit("there are too many conditions that depend on each other".to_owned())
}
