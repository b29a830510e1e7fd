//! Clocks: what releases a cycle. The clocks of this file count and never wait.

use core::marker::PhantomData;

use super::Cycle;
use crate::rate::Rate;

/// Releases control cycles, one after the other.
///
/// An implementation waits as its world waits (a timer interrupt, `clock_nanosleep`, a message) and MUST keep these
/// rules:
///
/// - `n` of the first cycle is 0 or more, and grows by `1 + missed` from one cycle to the next, so that
///   cycles run + releases missed = releases.
/// - Lateness and missed releases are reported in [`CycleInfo`], never hidden by changing `n`.
/// - After the first `None` it returns `None` for ever.
///
/// [`Periodic`](crate::Periodic) keeps them over whatever tells the time and sleeps. A clock that waits in its own way
/// leaves the counting to [`Releases`](crate::Releases):
///
/// ```
/// use ceid_core::prelude::*;
/// use ceid_core::Releases;
/// use std::sync::atomic::{AtomicU64, Ordering};
///
/// /// Counted up by a timer interrupt, ten thousand times a second.
/// static TICKS: AtomicU64 = AtomicU64::new(0);
///
/// struct Interrupts { releases: Releases<Hz<100>> }
///
/// impl Clock for Interrupts {
///     type Rate = Hz<100>;
///
///     fn wait(&mut self) -> Option<CycleInfo> {
///         loop {
///             let now_ns = TICKS.load(Ordering::Relaxed) * 100_000;
///             if now_ns >= self.releases.next_ns() {
///                 return self.releases.begin(now_ns);
///             }
///             // Here a microcontroller sleeps until the next interrupt.
///             # TICKS.fetch_add(1, Ordering::Relaxed);
///         }
///     }
/// }
///
/// let mut clock = Interrupts { releases: Releases::new(Overrun::Skip) }.take(3);
/// let mut releases = 0;
/// while let Some(cycle) = clock.next_cycle() {
///     assert_eq!(cycle.info().release_ns, releases * 10_000_000);
///     releases += 1;
/// }
/// ```
pub trait Clock {
    /// The nominal rate of the cycles.
    type Rate: Rate;

    /// Waits for the next release, and describes it; `None` ends the loop.
    ///
    /// This is for implementing a clock. To run one, use [`Cyclic`](crate::Cyclic) or
    /// [`next_cycle`](Clock::next_cycle). Blocks as long as the clock chooses: at most until its next release, for a clock
    /// of this crate. Those do not allocate or panic.
    fn wait(&mut self) -> Option<CycleInfo>;

    /// Waits for the next release, and returns the token that [`ceid!`](crate::ceid) takes; `None` ends the loop.
    ///
    /// Blocks as long as [`wait`](Clock::wait) does, and allocates nothing beside it. Not to be overridden.
    #[must_use = "a cycle that is not passed to `ceid!` updates no filter"]
    #[inline]
    fn next_cycle(&mut self) -> Option<Cycle<'_, Self::Rate>> {
        self.wait().map(Cycle::new)
    }

    /// Ends after `cycles` more cycles: for tests, simulations, and loops with an end. Does not allocate or block.
    #[inline]
    fn take(self, cycles: u64) -> Take<Self>
    where
        Self: Sized,
    {
        Take { clock: self, remaining: cycles }
    }
}

/// What a clock says about one cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct CycleInfo {
    /// The number of this release, counted from 0, missed releases included.
    pub n: u64,
    /// When this release was due, in nanoseconds after release 0.
    pub release_ns: u64,
    /// How long after its release the cycle really began, in nanoseconds; 0 for clocks that only count.
    pub late_ns: u64,
    /// How many releases passed without a cycle since the previous cycle.
    pub missed: u64,
}

/// A clock that never waits and never ends: each cycle is released as soon as the one before it is over.
///
/// For loops that are paced by something else (a blocking read, an interrupt that calls), and for simulated time: the
/// times it reports are nominal, so two runs are alike. Does not allocate, does not block.
#[derive(Debug, Clone)]
pub struct Free<R> {
    next: u64,
    rate: PhantomData<R>,
}

impl<R: Rate> Free<R> {
    /// A clock before its first cycle, which will have the number 0. Does not allocate or block.
    #[must_use]
    #[inline]
    pub const fn new() -> Self {
        Self { next: 0, rate: PhantomData }
    }

    /// Begins the next cycle: [`next_cycle`](Clock::next_cycle) of a clock that never ends. For functions that are
    /// called once per cycle, such as [`RealtimeFunctionality::cycle`](crate::RealtimeFunctionality::cycle).
    ///
    /// Does not allocate or block.
    #[must_use = "a cycle that is not passed to `ceid!` updates no filter"]
    #[inline]
    pub fn begin_cycle(&mut self) -> Cycle<'_, R> {
        Cycle::new(self.release())
    }

    #[inline]
    fn release(&mut self) -> CycleInfo {
        let n = self.next;
        self.next += 1;
        CycleInfo { n, release_ns: R::release_ns(n), ..CycleInfo::default() }
    }
}

impl<R: Rate> Default for Free<R> {
    fn default() -> Self {
        Self::new()
    }
}

impl<R: Rate> Clock for Free<R> {
    type Rate = R;

    #[inline]
    fn wait(&mut self) -> Option<CycleInfo> {
        Some(self.release())
    }
}

/// A clock that ends after some cycles, made by [`Clock::take`]. Blocks as its inner clock does.
#[derive(Debug, Clone)]
pub struct Take<C> {
    clock: C,
    remaining: u64,
}

impl<C: Clock> Clock for Take<C> {
    type Rate = C::Rate;

    #[inline]
    fn wait(&mut self) -> Option<CycleInfo> {
        self.remaining = self.remaining.checked_sub(1)?;
        self.clock.wait()
    }
}
