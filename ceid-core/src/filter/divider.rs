//! Slower parts of a faster cycle, by counting cycles. Never by comparing times: a jittery clock would then skip or
//! repeat a release of the slower part.

use core::marker::PhantomData;

use crate::rate::Rate;

/// Counts cycles for a part that runs at the slower rate `S`; for composites written by hand, with
/// [`Tick::every`](crate::Tick::every).
///
/// The part runs in the first cycle, and then in every `R::HZ / S::HZ`-th cycle that is entered, where `R` is the
/// rate of the faster cycle. A release that the clock missed is not counted, so a late loop delays the slower part
/// instead of dropping one of its updates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Divider<S> {
    /// Cycles to let pass before the next due one; in range `0 .. R::HZ / S::HZ`.
    remaining: u32,
    rate: PhantomData<S>,
}

impl<S: Rate> Divider<S> {
    /// A divider that is due in the first cycle. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn new() -> Self {
        Self { remaining: 0, rate: PhantomData }
    }

    /// Counts one cycle at the rate `R`, and says whether the slower part is due in it.
    #[inline]
    pub(super) fn is_due<R: Rate>(&mut self) -> bool {
        const {
            assert!(
                R::HZ % S::HZ == 0,
                "the slower rate does not divide the rate of the cycle: its filter cannot run every N-th cycle"
            );
        }
        if self.remaining == 0 {
            self.remaining = R::HZ / S::HZ - 1;
            true
        } else {
            self.remaining -= 1;
            false
        }
    }
}

impl<S: Rate> Default for Divider<S> {
    fn default() -> Self {
        Self::new()
    }
}
