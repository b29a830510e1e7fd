//! The main loop of a program without an operating system.

use super::{CyclicTask, RealtimeThread, Until, cooperative};
#[cfg(doc)]
use crate::cycle::Overrun;
use crate::cycle::Time;

/// Runs tasks one cycle at a time in the calling thread, in the time of a [`Time`]: for bare metal.
///
/// The task with the earliest release runs next, the first of several; none interrupts another. So a task is late by at
/// most the longest cycles of the others, and each task's [`Overrun`] says what happens if that makes it
/// miss a release. Does not allocate.
///
/// ```
/// use ceid_core::prelude::*;
/// use ceid_core::Time;
/// use ceid_core::thread::{SuperloopCycleThread, Task, Until};
/// use core::time::Duration;
/// # struct Timer(u64);
/// # impl Time for Timer {
/// #     fn now_ns(&mut self) -> u64 { self.0 }
/// #     fn sleep_until_ns(&mut self, _: u64) { self.0 += 10_000; }
/// # }
/// # struct Motor;
/// # impl RealtimeFunctionality for Motor {
/// #     type Rate = Hz<1000>;
/// #     fn cycle(&mut self, _: CycleInfo) -> Flow { Flow::Continue }
/// # }
/// # let timer = Timer(0);
///
/// let mut motor = Task::new("motor", Motor, Overrun::Skip);
/// SuperloopCycleThread::new(timer).run(&mut [&mut motor], Until::duration(Duration::from_millis(20)));
/// assert_eq!(motor.cycles(), 20);
/// ```
#[derive(Debug, Clone)]
pub struct SuperloopCycleThread<T> {
    time: T,
}

impl<T: Time> SuperloopCycleThread<T> {
    /// A main loop with this clock. Does not allocate, block or panic.
    #[must_use]
    pub const fn new(time: T) -> Self {
        Self { time }
    }
}

impl<T: Time> RealtimeThread for SuperloopCycleThread<T> {
    type Report = ();

    /// Does not allocate, and blocks for the whole run.
    fn run(&mut self, tasks: &mut [&mut dyn CyclicTask], until: Until<'_>) {
        cooperative::start(tasks, &until);
        let start_ns = self.time.now_ns();
        cooperative::run(tasks, &mut self.time, start_ns, until);
    }
}
