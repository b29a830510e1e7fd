//! What an assignment does to the value of a place, for telling counters, clocks and what is fed from each other.

use super::{About, Computed, ControlFlowGraph, Effect, NodeId, OTHER_HEADS, Place, Subject};

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
    /// How it counts, where it does so by a constant.
    pub tally: Option<Tally>,
}

/// How a whole number goes on by a constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tally {
    /// Whether it goes up.
    pub up: bool,
    /// By how much.
    pub step: u64,
    /// The number at which it is back at zero: `n = (n + 1) % 4`.
    pub around: Option<u64>,
    /// The number at which it stays where it would go above: `n = (n + 1).min(10)`.
    pub held_at: Option<u64>,
    /// Whether it stays at zero where it would go below.
    pub saturates: bool,
    /// Whether it may be less than zero, or come back to zero from its greatest value.
    pub may_be_less: bool,
}

impl Tally {
    /// The heads that the number can have afterwards, if it had one of these.
    #[must_use]
    pub fn after(&self, subject: &Subject, before: u32) -> u32 {
        let number = |head: &String| head.parse::<u64>().ok();
        let numbers: Vec<Option<u64>> = subject.heads.iter().map(number).collect();
        let is_other = |number: u64| !numbers.contains(&Some(number));
        let bit_of = |number: Option<u64>| number.map_or(OTHER_HEADS, |number| subject.bit(&number.to_string()));
        let mut after = 0;
        let had = numbers.iter().enumerate().filter(|(at, _)| before & (1 << *at) != 0);
        for (_, number) in had {
            let Some(number) = number else { return subject.anything() };
            after |= bit_of(self.next(*number));
        }
        if before & OTHER_HEADS != 0 {
            if self.around.is_none_or(|around| (0..around).any(is_other)) {
                after |= OTHER_HEADS;
            }
            for number in numbers.iter().copied().flatten() {
                after |= if self.comes_to(number, &is_other) { bit_of(Some(number)) } else { 0 };
            }
        }
        after & subject.anything()
    }

    /// The number behind one; nothing if that is less than zero.
    #[must_use]
    pub fn next(&self, number: u64) -> Option<u64> {
        match (self.up, self.around) {
            (true, Some(around)) => number.checked_add(self.step).map(|next| next % around),
            (true, None) => {
                number.checked_add(self.step).map(|next| self.held_at.map_or(next, |bound| next.min(bound)))
            }
            (false, _) if self.saturates => Some(number.saturating_sub(self.step)),
            (false, _) => number.checked_sub(self.step),
        }
    }

    /// Whether a number can come behind one of those of which nothing is known.
    fn comes_to(&self, number: u64, is_other: &dyn Fn(u64) -> bool) -> bool {
        match (self.up, self.around) {
            (true, Some(around)) => number < around,
            (true, None) if self.held_at.is_some() => self.held_at.is_some_and(|bound| number <= bound),
            (true, None) => number.checked_sub(self.step).map_or(self.may_be_less, is_other),
            (false, _) if self.saturates && number == 0 => (0..=self.step).any(is_other),
            (false, _) => number.checked_add(self.step).is_some_and(is_other),
        }
    }
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
    /// It is one step up, and held at a bound: `n = (n + 1).min(FULL)`.
    CountsUpTo,
    /// It is one step down, and held at a bound.
    CountsDownTo,
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
    /// Bits of it are set, and none is cleared: `flags |= read()`.
    Raises,
    /// Bits of it are cleared, and none is set.
    Lowers,
    /// It has nothing to do with the one before.
    Other,
}

impl ChangeKind {
    /// Whether it counts.
    #[must_use]
    pub fn counts(self) -> bool {
        matches!(self, Self::CountsUp | Self::CountsDown | Self::CountsUpTo | Self::CountsDownTo)
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
