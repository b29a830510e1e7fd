//! What a search has found: its states, and how its ways end.

use std::collections::BTreeSet;

use super::State;
use crate::count::assumed::Assumed;
use crate::count::counts::Count;
use crate::count::returned;
use crate::flow::{Cause, SubjectId};

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
