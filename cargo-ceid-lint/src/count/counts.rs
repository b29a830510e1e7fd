//! How often: none, once, many, and once for every sample of a loop of its own.

/// How often something ran on a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Count {
    /// Not at all.
    #[default]
    Zero,
    /// Exactly once.
    One,
    /// Once for each round of a loop that is a cycle of its own.
    PerSample,
    /// Twice or more.
    Many,
}

impl Count {
    /// First this often, then that often.
    #[must_use]
    pub fn then(self, next: Self) -> Self {
        match (self, next) {
            (Self::Zero, other) | (other, Self::Zero) => other,
            _ => Self::Many,
        }
    }

    /// The number in the proof report: 2 for 'many'.
    #[must_use]
    pub fn number(self) -> u8 {
        match self {
            Self::Zero => 0,
            Self::One | Self::PerSample => 1,
            Self::Many => 2,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Count::{self, Many, One, PerSample, Zero};

    const ALL: [Count; 4] = [Zero, One, PerSample, Many];

    #[test]
    fn nothing_changes_nothing() {
        for count in ALL {
            assert_eq!(Zero.then(count), count);
            assert_eq!(count.then(Zero), count);
        }
    }

    #[test]
    fn order_of_grouping_does_not_matter() {
        for a in ALL {
            for b in ALL {
                for c in ALL {
                    assert_eq!(a.then(b).then(c), a.then(b.then(c)));
                }
            }
        }
    }

    #[test]
    fn a_sample_loop_beside_another_update_is_many() {
        assert_eq!(PerSample.then(One), Many);
        assert_eq!(PerSample.then(PerSample), Many);
    }
}
