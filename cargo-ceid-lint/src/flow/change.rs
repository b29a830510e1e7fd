//! What an assignment does to the value of a place, for telling counters, clocks and what is fed from each other.

use super::Computed;

/// An assignment of the source.
#[derive(Clone, Debug)]
pub struct Change {
    /// What its value is computed from.
    pub computed: Computed,
    /// How the value goes on from the one before.
    pub kind: ChangeKind,
}

/// How a value goes on from the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChangeKind {
    /// It is a constant.
    Constant,
    /// It is one step up or down.
    Counts,
    /// It counts and goes round by itself: `n = (n + 1) % 10`.
    Wraps,
    /// Something that is not constant is added to it.
    Accumulates,
    /// It has nothing to do with the one before.
    Other,
}

impl ChangeKind {
    /// The kind of a choice between two values.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        match (self, other) {
            (left, right) if left == right => left,
            (Self::Constant, Self::Counts) | (Self::Counts, Self::Constant) => Self::Wraps,
            _ => Self::Other,
        }
    }
}
