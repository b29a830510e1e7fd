//! Threads with real-time priorities on Linux (feature `linux-rt`).

use core::hint::black_box;
use core::time::Duration;
use std::fs::{File, OpenOptions};
use std::io::{self, Write as _};
use std::vec::Vec;

use super::workers::{self, Workers};
use super::{CyclicTask, Granted, Privilege, Privileges, RealtimeThread, Until, system_calls};
use crate::cycle::Time;

/// Runs each task in a thread of its own, with a real-time priority, locked memory and absolute sleeps.
///
/// Before release 0 it asks the kernel for
///
/// - the [`Scheduling`] of each thread,
/// - memory that is never swapped out (`mlockall`; it stays locked after the run, because it belongs to the process),
/// - processors that do not go into deep sleep while the run lasts (`/dev/cpu_dma_latency`; costs energy),
/// - one processor for all threads, if [`on_processor`](Self::on_processor) names one,
///
/// and reads back what the kernel made of it. Nothing that is refused is ignored: it is in the [`Privileges`], and
/// [`IfRefused`] says whether the run takes place all the same. A run of no duration asks and calls nothing: a test of
/// the machine.
///
/// ```
/// use ceid_core::prelude::*;
/// use ceid_core::thread::{IfRefused, RtPreemptCycleThread, Scheduling, Task, Until};
/// use core::time::Duration;
/// # struct Motor;
/// # impl RealtimeFunctionality for Motor {
/// #     type Rate = Hz<1000>;
/// #     fn cycle(&mut self, _: CycleInfo) -> Flow { Flow::Continue }
/// # }
///
/// let mut motor = Task::new("motor", Motor, Overrun::Skip);
/// let mut thread = RtPreemptCycleThread::new(Scheduling::Fifo { priority: 80 }, IfRefused::RunAnyway);
/// let privileges = thread.run(&mut [&mut motor], Until::duration(Duration::from_millis(10)));
/// if privileges.is_refused() {
///     eprintln!("{privileges}");
/// }
/// assert_eq!(motor.released(), 10);
/// ```
///
/// Works on every Linux; how late a cycle may begin depends on the kernel (`PREEMPT_RT`) and the machine.
#[doc(alias = "RTPreemptCycleLogicalThread")]
#[derive(Debug, Clone)]
pub struct RtPreemptCycleThread {
    scheduling: Scheduling,
    if_refused: IfRefused,
    processor: Option<usize>,
}

/// How the kernel chooses between the threads of a run and others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Scheduling {
    /// `SCHED_FIFO`, rate-monotonic: the fastest tasks have this priority (1 to 99), and each slower rate has one less.
    Fifo {
        /// The priority of the fastest tasks.
        priority: u8,
    },
    /// `SCHED_DEADLINE`: in each period, which is also its deadline, a thread gets this much time. The kernel admits
    /// the threads only if all can have it; one that takes longer waits for its next period.
    Deadline {
        /// The processor time of one cycle, at its longest.
        runtime: Duration,
    },
}

/// What happens when the kernel refuses something.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum IfRefused {
    /// Run with what there is.
    RunAnyway,
    /// Call no functionality: every task ends as [`NotStarted`](super::Outcome::NotStarted).
    DoNotRun,
}

impl RtPreemptCycleThread {
    /// Real-time threads, whose tasks are scheduled like this. Does not allocate, block or panic.
    #[must_use]
    pub const fn new(scheduling: Scheduling, if_refused: IfRefused) -> Self {
        Self { scheduling, if_refused, processor: None }
    }

    /// Keeps all threads on one processor. Does not allocate, block or panic.
    ///
    /// The kernel refuses it together with [`Scheduling::Deadline`].
    #[must_use]
    pub const fn on_processor(self, processor: usize) -> Self {
        Self { processor: Some(processor), ..self }
    }
}

impl RealtimeThread for RtPreemptCycleThread {
    type Report = Privileges;

    /// Allocates, makes threads and opens a file before release 0, not in the loop. Blocks for the whole run.
    fn run(&mut self, tasks: &mut [&mut dyn CyclicTask], until: Until<'_>) -> Privileges {
        let memory_lock = Privilege::of(system_calls::lock_memory());
        // Deep sleep is forbidden for as long as the file is open.
        let awake = keep_processors_awake();
        let shallow_sleep = Privilege::of(awake.as_ref().map(|_| ()).map_err(|error| error.kind().into()));
        let mut rates: Vec<_> = tasks.iter().map(|task| task.hz()).collect();
        rates.sort_unstable_by(|one, other| other.cmp(one));
        rates.dedup();
        let process = Privileges { memory_lock, shallow_sleep, ..Privileges::default() };
        let world = RtPreempt { asked: self, refused_before: process.is_refused(), rates };
        Privileges { memory_lock, shallow_sleep, ..workers::run(tasks, &world, until) }
    }
}

struct RtPreempt<'a> {
    asked: &'a RtPreemptCycleThread,
    /// The process was refused something.
    refused_before: bool,
    /// The rates of the tasks, the fastest first.
    rates: Vec<u32>,
}

impl Workers for RtPreempt<'_> {
    type Time = Monotonic;

    fn prepare(&self, task: &'static str, hz: u32) -> Granted {
        touch_stack();
        // The processor first: the kernel does not move a thread that has a deadline.
        let processor = self.asked.processor.map_or(Privilege::NotAsked, |it| Privilege::of(system_calls::stay_on(it)));
        let scheduling = match self.asked.scheduling {
            Scheduling::Fifo { priority } => {
                let slower_by = self.rates.iter().position(|rate| *rate == hz).unwrap_or(0);
                let slower_by = i32::try_from(slower_by).unwrap_or(i32::MAX);
                // A priority of 0 is left to be refused.
                let priority = i32::from(priority);
                system_calls::schedule_fifo((priority - slower_by).max(priority.min(1)))
            }
            Scheduling::Deadline { runtime } => {
                let runtime_ns = u64::try_from(runtime.as_nanos()).unwrap_or(u64::MAX);
                system_calls::schedule_deadline(runtime_ns, 1_000_000_000 / u64::from(hz))
            }
        };
        let priority = system_calls::scheduling().map_or(0, |(_, priority)| priority);
        Granted { task, timer_slack: Privilege::NotAsked, scheduling: Privilege::of(scheduling), processor, priority }
    }

    fn may_begin(&self, granted: &[Granted]) -> bool {
        let threads = Privileges { threads: granted.into(), ..Privileges::default() };
        self.asked.if_refused == IfRefused::RunAnyway || !(self.refused_before || threads.is_refused())
    }

    fn time(&self) -> Monotonic {
        Monotonic
    }
}

struct Monotonic;

impl Time for Monotonic {
    #[inline]
    fn now_ns(&mut self) -> u64 {
        system_calls::monotonic_ns()
    }

    #[inline]
    fn sleep_until_ns(&mut self, deadline_ns: u64) {
        system_calls::sleep_until(deadline_ns);
    }
}

/// Uses the stack once, so that the cycles find its pages in place.
#[inline(never)]
fn touch_stack() {
    black_box([0_u8; 256 * 1024]);
}

fn keep_processors_awake() -> io::Result<File> {
    let mut file = OpenOptions::new().write(true).open("/dev/cpu_dma_latency")?;
    file.write_all(&0_i32.to_ne_bytes())?;
    Ok(file)
}
