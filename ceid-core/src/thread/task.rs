//! One functionality as a run sees it: its releases, its lateness, and why it ended. Nothing here waits.

use core::fmt;

use super::{Flow, Histogram, RealtimeFunctionality};
use crate::cycle::{Overrun, Releases};
use crate::rate::Rate;

/// A functionality with what a [`RealtimeThread`](super::RealtimeThread) needs to run it, and what it finds out.
///
/// The counts are those of the last run. With [`with_histogram`](Task::with_histogram) it also counts how late the
/// cycles began; the buckets are part of the task, so the loop does not allocate.
pub struct Task<F: RealtimeFunctionality, const BUCKETS: usize = 0> {
    name: &'static str,
    functionality: F,
    releases: Releases<F::Rate>,
    /// The number of releases of the run, and the last nanosecond before the one that is not part of it.
    end: u64,
    last_ns: u64,
    outcome: Option<Outcome>,
    lateness: Histogram<BUCKETS>,
}

/// Why a task ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// All releases before the end of the run are over.
    Completed,
    /// By a [`StopSignal`](super::StopSignal).
    Stopped,
    /// The functionality returned [`Flow::Stop`](super::Flow::Stop).
    Finished,
    /// It missed a release under [`Overrun::Stop`].
    Overran,
    /// The functionality panicked. It is not called again, in this run or another.
    Panicked,
    /// Another task of the run ended it.
    EndedByAnother,
    /// The run did not begin: a privilege was refused, or a thread could not be made.
    NotStarted,
}

impl<F: RealtimeFunctionality> Task<F> {
    /// A task that has not run. The name is that of its thread, and is used in reports.
    ///
    /// Does not allocate, block or panic.
    // Compile errors quote the line of the function to whoever leaves the choice out.
    #[rustfmt::skip]
    #[must_use]
    pub const fn new(name: &'static str, functionality: F, overrun: Overrun) -> Self { // choose what becomes of late releases
        let lateness = Histogram::with_width_ns(1);
        Self { name, functionality, releases: Releases::new(overrun), end: 0, last_ns: 0, outcome: None, lateness }
    }

    /// Counts how late cycles begin, in `BUCKETS` buckets of `width_ns` nanoseconds.
    ///
    /// ```
    /// # use ceid_core::prelude::*;
    /// # use ceid_core::thread::{SimulatedCycleThread, Task, Until};
    /// # use core::time::Duration;
    /// # struct Motor;
    /// # impl RealtimeFunctionality for Motor {
    /// #     type Rate = Hz<1000>;
    /// #     fn cycle(&mut self, _: CycleInfo) -> Flow { Flow::Continue }
    /// # }
    /// let mut motor = Task::new("motor", Motor, Overrun::Skip).with_histogram::<1000>(1_000);
    /// SimulatedCycleThread::new().run(&mut [&mut motor], Until::duration(Duration::from_secs(1)));
    /// assert_eq!(motor.lateness().max_ns(), 0);
    /// ```
    ///
    /// Does not allocate, block or panic.
    #[must_use]
    pub fn with_histogram<const BUCKETS: usize>(self, width_ns: u64) -> Task<F, BUCKETS> {
        let Self { name, functionality, releases, end, last_ns, outcome, .. } = self;
        let lateness = Histogram::with_width_ns(width_ns);
        Task { name, functionality, releases, end, last_ns, outcome, lateness }
    }
}

impl<F: RealtimeFunctionality, const BUCKETS: usize> Task<F, BUCKETS> {
    /// The cycles of the last run. Does not allocate, block or panic.
    #[must_use]
    pub fn cycles(&self) -> u64 {
        self.releases.cycles()
    }

    /// The releases of the last run that passed without a cycle. Does not allocate, block or panic.
    #[must_use]
    pub fn missed(&self) -> u64 {
        self.releases.missed()
    }

    /// Cycles and missed releases together. Does not allocate, block or panic.
    #[must_use]
    pub fn released(&self) -> u64 {
        self.releases.released()
    }

    /// How late the cycles of the last run began; empty, but for the shortest and the longest, without
    /// [`with_histogram`](Task::with_histogram). Does not allocate, block or panic.
    #[must_use]
    pub const fn lateness(&self) -> &Histogram<BUCKETS> {
        &self.lateness
    }

    /// Why the last run ended for this task; `None` before the first run. Does not allocate, block or panic.
    #[must_use]
    pub const fn outcome(&self) -> Option<Outcome> {
        self.outcome
    }

    /// The functionality between two runs. Does not allocate, block or panic.
    #[must_use]
    pub const fn functionality(&self) -> &F {
        &self.functionality
    }

    /// The functionality between two runs. Does not allocate, block or panic.
    #[must_use]
    pub const fn functionality_mut(&mut self) -> &mut F {
        &mut self.functionality
    }

    /// Gives the functionality back. Does not allocate, block or panic.
    #[must_use]
    pub fn into_functionality(self) -> F {
        self.functionality
    }
}

impl<F: RealtimeFunctionality, const BUCKETS: usize> Task<F, BUCKETS> {
    fn is_complete(&self) -> bool {
        self.releases.released() >= self.end
    }
}

impl<F: RealtimeFunctionality, const BUCKETS: usize> fmt::Debug for Task<F, BUCKETS> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Task")
            .field("name", &self.name)
            .field("cycles", &self.cycles())
            .field("missed", &self.missed())
            .field("outcome", &self.outcome)
            .finish_non_exhaustive()
    }
}

/// A task of any functionality, as a [`RealtimeThread`](super::RealtimeThread) takes it. Only [`Task`] implements it.
///
/// To run tasks in a world of your own, give [`SuperloopCycleThread`](super::SuperloopCycleThread) its
/// [`Time`](crate::Time). The methods are for this crate.
pub trait CyclicTask: Send + sealed::Sealed {
    #[doc(hidden)]
    fn name(&self) -> &'static str;

    /// Releases per second.
    #[doc(hidden)]
    fn hz(&self) -> u32;

    /// Begins a run: counts from release 0. Returns whether the functionality can be called, which it cannot after a
    /// panic.
    #[doc(hidden)]
    fn start(&mut self, duration_ns: Option<u64>) -> bool;

    /// The number of the next release, and when it is due; `None` if the task has ended.
    #[doc(hidden)]
    fn next_release(&self) -> Option<(u64, u64)>;

    /// Runs the cycle that is due, or the newest of several. Returns whether the run goes on.
    #[doc(hidden)]
    fn run_cycle(&mut self, now_ns: u64) -> bool;

    /// Ends the task, unless it has ended already.
    #[doc(hidden)]
    fn end(&mut self, outcome: Outcome);
}

mod sealed {
    pub trait Sealed {}
}

impl<F: RealtimeFunctionality, const BUCKETS: usize> sealed::Sealed for Task<F, BUCKETS> {}

impl<F: RealtimeFunctionality, const BUCKETS: usize> CyclicTask for Task<F, BUCKETS> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn hz(&self) -> u32 {
        F::Rate::HZ
    }

    fn start(&mut self, duration_ns: Option<u64>) -> bool {
        self.releases = Releases::new(self.releases.overrun());
        self.end = match duration_ns {
            None => u64::MAX,
            // Those that are due one nanosecond before the end.
            Some(ns) => ns.checked_sub(1).map_or(0, F::Rate::released_by),
        };
        self.last_ns = F::Rate::release_ns(self.end).saturating_sub(1);
        self.lateness.clear();
        if self.outcome == Some(Outcome::Panicked) {
            return false;
        }
        self.outcome = self.is_complete().then_some(Outcome::Completed);
        true
    }

    #[inline]
    fn next_release(&self) -> Option<(u64, u64)> {
        self.outcome.is_none().then(|| (self.releases.released(), self.releases.next_ns()))
    }

    #[inline]
    fn run_cycle(&mut self, now_ns: u64) -> bool {
        // Releases from the end on are not part of the run, however late it is.
        let Some(mut info) = self.releases.begin(now_ns.min(self.last_ns)) else {
            self.outcome = Some(Outcome::Overran);
            return false;
        };
        info.late_ns = now_ns.saturating_sub(info.release_ns);
        self.lateness.record(info.late_ns);
        // Stays if the functionality unwinds; without `std` there is no other way to know.
        self.outcome = Some(Outcome::Panicked);
        let flow = self.functionality.cycle(info);
        self.outcome = match flow {
            Flow::Stop => Some(Outcome::Finished),
            Flow::Continue => self.is_complete().then_some(Outcome::Completed),
        };
        flow == Flow::Continue
    }

    fn end(&mut self, outcome: Outcome) {
        self.outcome.get_or_insert(outcome);
    }
}
