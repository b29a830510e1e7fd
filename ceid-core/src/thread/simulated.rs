//! Virtual time: the simulator of the paper.

use super::{CyclicTask, RealtimeThread, Until, cooperative};
use crate::cycle::Time;

/// Runs tasks in virtual time: nobody waits, and a run is a function of its tasks alone.
///
/// The cycles of all tasks run one after the other in the calling thread, by the time of their releases and, where these
/// are equal, in the order of the tasks. A cycle takes no virtual time, so there is no lateness and no overrun.
#[doc(alias = "simulator")]
#[derive(Debug, Clone, Copy, Default)]
pub struct SimulatedCycleThread(());

impl SimulatedCycleThread {
    /// A thread in virtual time. Does not allocate, block or panic.
    #[must_use]
    pub const fn new() -> Self {
        Self(())
    }
}

impl RealtimeThread for SimulatedCycleThread {
    type Report = ();

    /// Does not allocate, and blocks for as long as the cycles take.
    fn run(&mut self, tasks: &mut [&mut dyn CyclicTask], until: Until<'_>) {
        cooperative::start(tasks, &until);
        cooperative::run(tasks, &mut Virtual { now_ns: 0 }, 0, until);
    }
}

struct Virtual {
    now_ns: u64,
}

impl Time for Virtual {
    #[inline]
    fn now_ns(&mut self) -> u64 {
        self.now_ns
    }

    #[inline]
    fn sleep_until_ns(&mut self, deadline_ns: u64) {
        self.now_ns = deadline_ns;
    }
}
