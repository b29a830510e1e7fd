//! A clock that waits, over whatever tells the time and sleeps. Counting is not done here.

use super::{Clock, CycleInfo, Overrun, Releases};
use crate::rate::Rate;

/// Tells the time and sleeps: the one thing that [`Periodic`] needs of a platform.
///
/// With the feature `std`, `StdTime` is one. On bare metal it is a hardware timer and `wfi`; in a
/// test, a variable.
pub trait Time {
    /// Nanoseconds since some moment in the past that stays the same. Never decreases.
    ///
    /// Called in the loop, so an implementation should neither allocate nor block.
    fn now_ns(&mut self) -> u64;

    /// Blocks until `at_ns`, and does not return before; returns at once if that has passed. Should not allocate.
    fn sleep_until_ns(&mut self, at_ns: u64);
}

/// A clock that releases `R::HZ` cycles per second, and sleeps between them.
///
/// Release 0 is the moment of the first wait, so whatever the program does before its loop costs no release.
#[cfg_attr(feature = "std", doc = "```")]
#[cfg_attr(not(feature = "std"), doc = "```ignore")]
/// use ceid_core::prelude::*;
/// # struct KalmanF; impl<R: Rate> SampledFilter<R> for KalmanF { fn update(&mut self, _: Tick<'_, R>) {} }
/// # filters! { struct Filters @ 1000 Hz { kf: KalmanF } }
///
/// let clock = Periodic::<Hz<1000>, _>::new(StdTime::new(), Overrun::Skip);
/// let mut control = Cyclic::new(Filters::register(KalmanF), clock);
/// each_cycle!(f, info in control => {
///     println!("cycle {} began {} ns late, {} missed", info.n, info.late_ns, info.missed);
///     if info.n >= 3 { break }
/// });
/// let releases = control.clock().releases();
/// assert_eq!(releases.cycles() + releases.missed(), releases.released());
/// ```
#[doc(alias = "ChronoCycleLogicalThread")]
#[derive(Debug, Clone)]
pub struct Periodic<R, T> {
    time: T,
    /// The time of release 0, from the first wait on.
    start_ns: Option<u64>,
    releases: Releases<R>,
}

impl<R: Rate, T: Time> Periodic<R, T> {
    /// A clock before its first cycle. Does not read the time, allocate or block.
    // Compile errors quote the line of the function to whoever leaves the choice out.
    #[rustfmt::skip]
    #[must_use]
    #[inline]
    pub const fn new(time: T, overrun: Overrun) -> Self { // choose what becomes of late releases: `Overrun::Skip`, `CatchUp` or `Stop`
        Self { time, start_ns: None, releases: Releases::new(overrun) }
    }

    /// The releases counted so far: how many had their cycle, and how many were missed.
    /// Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn releases(&self) -> &Releases<R> {
        &self.releases
    }
}

impl<R: Rate, T: Time> Clock for Periodic<R, T> {
    type Rate = R;

    /// Blocks until the next release, as [`Time::sleep_until_ns`] does. Does not allocate or panic if its time does not.
    #[inline]
    fn wait(&mut self) -> Option<CycleInfo> {
        if self.releases.is_stopped() {
            return None;
        }
        let mut now_ns = self.time.now_ns();
        let start_ns = *self.start_ns.get_or_insert(now_ns);
        let due_ns = start_ns.saturating_add(self.releases.next_ns());
        if now_ns < due_ns {
            self.time.sleep_until_ns(due_ns);
            now_ns = self.time.now_ns();
        }
        self.releases.begin(now_ns.saturating_sub(start_ns))
    }
}
