//! What a search has found: its states, and how its ways end.

use std::collections::BTreeSet;

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
    /// Conditions that could not be told apart, because there are too many.
    pub(in crate::count) dropped: BTreeSet<SubjectId>,
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

    /// Whether a way passes a condition twice that could not be told apart, or one that something gives a value: then it may not exist.
    pub(in crate::count) fn asks_dropped(&self, exploration: &Exploration, end: &End) -> bool {
        let mut asked = BTreeSet::new();
        let is_given = |id: &SubjectId| self.dependence.assigned.get(id).is_some_and(|writers| !writers.is_empty());
        let mut may_be_known = |id: SubjectId| is_given(&id) || !asked.insert(id);
        !exploration.dropped.is_empty()
            && exploration.path(end.at).iter().any(|at| match &self.graph.node(exploration.states[*at].node).effect {
                Effect::Branch(test) => {
                    test.subject.is_some_and(|id| exploration.dropped.contains(&id) && may_be_known(id))
                }
                _ => false,
            })
    }
}

impl Run<'_, '_> {
    /// The subjects that were not told apart, with those that are copied from one of them.
    pub(super) fn untracked(&self) -> BTreeSet<SubjectId> {
        let search = self.search;
        let is_tracked = |id: &SubjectId| self.tracked.subjects.contains(id);
        let mut found: BTreeSet<SubjectId> =
            self.tracked.dropped.iter().filter(|id| !is_tracked(id)).copied().collect();
        let mut before = 0;
        while found.len() > before {
            before = found.len();
            for (id, writers) in &search.dependence.assigned {
                let from = |writer: &NodeId| search.graph.subject_of(&search.graph.copied(*writer)?);
                if writers.iter().filter_map(from).any(|from| found.contains(&from)) {
                    found.insert(*id);
                }
            }
        }
        found
    }
}

/// Why a way that passes such conditions is not certain.
pub(in crate::count) fn too_many_conditions() -> Cause {
    Cause::Limit("there are too many conditions that depend on each other".to_owned())
}
