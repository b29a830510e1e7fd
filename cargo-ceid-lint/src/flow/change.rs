//! What an assignment does to the value of a place, for telling counters, clocks and what is fed from each other.

use super::{About, Computed, ControlFlowGraph, Effect, NodeId, Place};

/// An assignment of the source.
#[derive(Clone, Debug)]
pub struct Change {
    /// What its value is computed from.
    pub computed: Computed,
    /// How the value goes on from the one before.
    pub kind: ChangeKind,
    /// Whether it counts to where its type ends, and goes round there soon: `n = n.wrapping_add(1)` with a `u8`.
    pub goes_round: bool,
    /// What a truth value was asked of, if it was asked of anything.
    pub about: Option<Box<About>>,
}

/// How a value goes on from the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ChangeKind {
    /// It is a constant.
    Constant,
    /// It is one step up.
    CountsUp,
    /// It is one step down.
    CountsDown,
    /// It counts and goes round by itself: `n = (n + 1) % 10`.
    Wraps,
    /// It is turned round: `odd = !odd`.
    Toggles,
    /// Something that is not constant is added to it.
    Accumulates,
    /// Something that is not constant is taken from it.
    Spends,
    /// It is put into an option by `replace` or `insert`, so that something is there from then on.
    Fills,
    /// What is there is taken out of an option: a message is read, or a value is put back later.
    Empties,
    /// It has nothing to do with the one before.
    Other,
}

impl ChangeKind {
    /// Whether it counts.
    #[must_use]
    pub fn counts(self) -> bool {
        matches!(self, Self::CountsUp | Self::CountsDown)
    }

    /// The kind of a choice between two values.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        match (self, other) {
            (left, right) if left == right => left,
            (Self::Constant, counts) | (counts, Self::Constant) if counts.counts() || counts == Self::Wraps => {
                Self::Wraps
            }
            (Self::Wraps, counts) | (counts, Self::Wraps) if counts.counts() => Self::Wraps,
            _ => Self::Other,
        }
    }
}

impl ControlFlowGraph {
    /// The place whose value an assignment copies.
    #[must_use]
    pub fn copied(&self, at: NodeId) -> Option<Place> {
        let (Effect::Set(set) | Effect::Write(set)) = &self.node(at).effect else { return None };
        set.same_as.map(Place::var).or_else(|| self.copies.get(&at).cloned())
    }
}
