//! When a run ends.

use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;

/// A request to stop, raised by one part of a program and seen by the runs that were given it.
///
/// `const`, so it may be a `static`, and an interrupt or signal handler may raise it.
///
/// ```
/// use ceid_core::thread::StopSignal;
///
/// static STOP: StopSignal = StopSignal::new();
/// STOP.raise();
/// assert!(STOP.is_raised());
/// ```
#[derive(Debug, Default)]
pub struct StopSignal(AtomicBool);

impl StopSignal {
    /// A signal that is not raised. Does not allocate, block or panic.
    #[must_use]
    #[inline]
    pub const fn new() -> Self {
        Self(AtomicBool::new(false))
    }

    /// Asks to stop, for good. Does not allocate, block or panic; one atomic store.
    #[inline]
    pub fn raise(&self) {
        // Release, so that what was written before the request is seen by whoever sees the request.
        self.0.store(true, Ordering::Release);
    }

    /// Whether it was raised. Does not allocate, block or panic; one atomic load.
    #[must_use]
    #[inline]
    pub fn is_raised(&self) -> bool {
        self.0.load(Ordering::Acquire)
    }
}

/// When a run ends, unless a task ends it before: after a duration, at a stop request, or neither.
///
/// ```
/// use ceid_core::thread::{StopSignal, Until};
/// use core::time::Duration;
///
/// let stop = StopSignal::new();
/// let until = Until::duration(Duration::from_secs(7)).or_stopped(&stop);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Until<'s> {
    pub(super) duration_ns: Option<u64>,
    stop: Option<&'s StopSignal>,
    /// Raised by the threads of one run for each other.
    end: Option<&'s StopSignal>,
}

impl<'s> Until<'s> {
    /// Until a task ends the run. Does not allocate, block or panic.
    #[must_use]
    pub const fn finished() -> Self {
        Self { duration_ns: None, stop: None, end: None }
    }

    /// Runs the releases that are due before `duration`: none if it is zero. Does not allocate, block or panic.
    ///
    /// A duration of more than 584 years has no end.
    #[must_use]
    pub const fn duration(duration: Duration) -> Self {
        let ns = duration.as_nanos();
        let duration_ns = if ns > u64::MAX as u128 { None } else { Some(ns as u64) };
        Self { duration_ns, ..Self::finished() }
    }

    /// Until `stop` is raised. Does not allocate, block or panic.
    #[must_use]
    pub const fn stopped(stop: &'s StopSignal) -> Self {
        Self::finished().or_stopped(stop)
    }

    /// Also until `stop` is raised. Does not allocate, block or panic.
    #[must_use]
    pub const fn or_stopped(self, stop: &'s StopSignal) -> Self {
        Self { stop: Some(stop), ..self }
    }

    /// Also until another task of the run has raised `end`.
    #[cfg(feature = "std")]
    pub(super) const fn or_ended(self, end: &'s StopSignal) -> Self {
        Self { end: Some(end), ..self }
    }

    pub(super) fn is_stop_requested(&self) -> bool {
        self.stop.is_some_and(StopSignal::is_raised)
    }

    pub(super) fn is_ended(&self) -> bool {
        self.end.is_some_and(StopSignal::is_raised)
    }
}
