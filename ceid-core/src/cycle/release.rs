//! Which release comes next, and what becomes of the late ones: counting only, in exact integers. Nothing here reads a
//! clock or waits.

use core::marker::PhantomData;

use super::CycleInfo;
use crate::rate::Rate;

/// What to do about releases that passed while a cycle was still running. There is no default, because each answer is
/// wrong for somebody.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Overrun {
    /// Run the latest release, and count those before it as missed. The phase is kept.
    Skip,
    /// Run the late releases one after the other without a pause, as long as at most `max` of them wait behind the one
    /// that runs; older ones are missed. `max: 0` is [`Overrun::Skip`].
    CatchUp {
        /// How many late releases may wait.
        max: u32,
    },
    /// End the loop. The releases that passed are missed.
    Stop,
}

/// Counts the releases of a clock that waits: the part that all such clocks share.
///
/// At each moment, releases counted = cycles begun + releases missed. Release times come from [`Rate::release_ns`],
/// so no rounding adds up. No function of it allocates, blocks or panics, and each takes constant time.
///
/// ```
/// use ceid_core::{Hz, Overrun, Releases};
///
/// let mut releases = Releases::<Hz<1000>>::new(Overrun::Skip);
/// assert_eq!(releases.begin(20_000).unwrap().late_ns, 20_000);
/// assert_eq!(releases.next_ns(), 1_000_000);
///
/// // The cycle before took 3.5 ms: releases 1 and 2 have no cycle, release 3 is half a millisecond late.
/// let info = releases.begin(3_500_000).unwrap();
/// assert_eq!((info.n, info.missed, info.late_ns), (3, 2, 500_000));
/// assert_eq!(releases.cycles() + releases.missed(), releases.released());
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Releases<R> {
    overrun: Overrun,
    /// The number of the next release, which is the number of releases counted so far.
    next: u64,
    /// When the next release is due. Kept, because it is asked for more often than it changes.
    next_ns: u64,
    cycles: u64,
    missed: u64,
    stopped: bool,
    rate: PhantomData<R>,
}

impl<R: Rate> Releases<R> {
    /// Before release 0. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn new(overrun: Overrun) -> Self {
        Self { overrun, next: 0, next_ns: 0, cycles: 0, missed: 0, stopped: false, rate: PhantomData }
    }

    /// When the next release is due, in nanoseconds after release 0. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn next_ns(&self) -> u64 {
        self.next_ns
    }

    /// Begins a cycle at `now_ns` after release 0, and says which; `None` after an overrun under [`Overrun::Stop`],
    /// and for ever from then on.
    ///
    /// To be called when the next release is due. A call before that begins the next release with no lateness.
    /// Neither allocates nor blocks nor panics.
    #[inline]
    pub fn begin(&mut self, now_ns: u64) -> Option<CycleInfo> {
        if self.stopped {
            return None;
        }
        let mut following_ns = R::release_ns(self.next.saturating_add(1));
        // As long as the release after this one is not due, none is missed.
        let missed = if now_ns < following_ns { 0 } else { self.miss(now_ns)? };
        if missed > 0 {
            following_ns = R::release_ns(self.next.saturating_add(1));
        }
        let (n, release_ns) = (self.next, self.next_ns);
        self.next = n.saturating_add(1);
        self.next_ns = following_ns;
        self.cycles = self.cycles.saturating_add(1);
        Some(CycleInfo { n, release_ns, late_ns: now_ns.saturating_sub(release_ns), missed })
    }

    /// Passes over the releases that will have no cycle, and returns how many; `None` if that ends the loop.
    #[cold]
    fn miss(&mut self, now_ns: u64) -> Option<u64> {
        let due = R::released_by(now_ns).saturating_sub(self.next);
        let behind = due.saturating_sub(1);
        let missed = match self.overrun {
            Overrun::Skip => behind,
            Overrun::CatchUp { max } => behind.saturating_sub(u64::from(max)),
            Overrun::Stop if behind == 0 => 0,
            Overrun::Stop => {
                self.stopped = true;
                due
            }
        };
        self.next = self.next.saturating_add(missed);
        self.next_ns = R::release_ns(self.next);
        self.missed = self.missed.saturating_add(missed);
        (!self.stopped).then_some(missed)
    }

    /// How many releases have been counted, with a cycle or without. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn released(&self) -> u64 {
        self.next
    }

    /// How many releases have had their cycle. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn cycles(&self) -> u64 {
        self.cycles
    }

    /// How many releases passed without a cycle. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn missed(&self) -> u64 {
        self.missed
    }

    /// Whether an overrun has ended the loop. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn is_stopped(&self) -> bool {
        self.stopped
    }

    /// What becomes of late releases. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn overrun(&self) -> Overrun {
        self.overrun
    }
}
