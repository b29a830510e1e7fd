//! The threads of the bridge: one functionality on all of them, and what ends a run.

mod conserved;
mod endings;
mod no_allocation;
mod overruns;
#[cfg(all(feature = "linux-rt", target_os = "linux"))]
mod real_time;
#[cfg(all(feature = "std", target_os = "linux"))]
mod refused_threads;
mod same_everywhere;
#[cfg(feature = "std")]
mod soft;
mod virtual_time;

use ceid_core::Time;
use ceid_core::prelude::*;
use ceid_core::thread::{CyclicTask, Outcome, Until};
use std::time::Instant;

/// A clock of bare metal: an interrupt counts, and the loop looks often.
pub(crate) struct Timer(Instant);

impl Timer {
    pub(crate) fn new() -> Self {
        Self(Instant::now())
    }
}

impl Time for Timer {
    fn now_ns(&mut self) -> u64 {
        self.0.elapsed().as_nanos() as u64
    }

    fn sleep_until_ns(&mut self, _: u64) {
        std::hint::spin_loop();
    }
}

/// A functionality made of a closure.
pub(crate) struct Each<const HZ: u32, B>(pub(crate) B);

impl<const HZ: u32, B: FnMut(CycleInfo) -> Flow + Send> RealtimeFunctionality for Each<HZ, B> {
    type Rate = Hz<HZ>;

    fn cycle(&mut self, info: CycleInfo) -> Flow {
        self.0(info)
    }
}

/// Runs a test in every world, with its name.
pub(crate) trait InEveryWorld {
    fn test<T: RealtimeThread>(&self, world: &str, thread: T);

    fn run(&self) {
        self.test("simulated", ceid_core::thread::SimulatedCycleThread::new());
        self.test("superloop", ceid_core::thread::SuperloopCycleThread::new(Timer::new()));
        #[cfg(feature = "std")]
        self.test("chrono", ceid_core::thread::ChronoCycleThread::new());
        #[cfg(all(feature = "linux-rt", target_os = "linux"))]
        {
            use ceid_core::thread::{IfRefused, RtPreemptCycleThread, Scheduling};
            let scheduling = Scheduling::Fifo { priority: 10 };
            self.test("rt-preempt", RtPreemptCycleThread::new(scheduling, IfRefused::RunAnyway));
        }
    }
}

/// What is known of a task after a run: cycles, missed releases, outcome.
pub(crate) type Counts = (u64, u64, Option<Outcome>);

pub(crate) fn counts<F: RealtimeFunctionality, const N: usize>(task: &ceid_core::thread::Task<F, N>) -> Counts {
    (task.cycles(), task.missed(), task.outcome())
}

/// Runs tasks and drops the report, which differs from world to world.
pub(crate) fn run<T: RealtimeThread>(mut thread: T, tasks: &mut [&mut dyn CyclicTask], until: Until<'_>) {
    let _report = thread.run(tasks, until);
}
