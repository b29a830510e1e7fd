//! The time of the standard library (feature `std`).

use core::time::Duration;
use std::thread;
use std::time::Instant;

use super::Time;

/// The monotonic clock and the sleep of the standard library.
///
/// How late a sleep ends is the operating system's affair; [`CycleInfo::late_ns`](crate::CycleInfo::late_ns) reports it.
#[derive(Debug, Clone, Copy)]
pub struct StdTime {
    origin: Instant,
}

impl StdTime {
    /// A time that begins now. Does not allocate or block.
    #[must_use]
    pub fn new() -> Self {
        Self { origin: Instant::now() }
    }
}

impl Default for StdTime {
    fn default() -> Self {
        Self::new()
    }
}

impl Time for StdTime {
    /// Does not allocate or block. Saturates after 584 years.
    fn now_ns(&mut self) -> u64 {
        u64::try_from(self.origin.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }

    /// Blocks until `at_ns`. Does not allocate.
    fn sleep_until_ns(&mut self, at_ns: u64) {
        let now_ns = self.now_ns();
        thread::sleep(Duration::from_nanos(at_ns.saturating_sub(now_ns)));
    }
}
