//! Threads that run a functionality cycle by cycle: one in virtual time, two on an operating system, one on bare metal.
//!
//! The paper's bridge: what a robot does ([`RealtimeFunctionality`]) knows nothing of the thread that runs it
//! ([`RealtimeThread`]), so the same functionality runs on all of them, and changing the world is changing one type.
//!
//! | thread | time | tasks | needs |
//! | --- | --- | --- | --- |
//! | [`SimulatedCycleThread`] | virtual: no waiting, every run alike | in one thread | nothing |
//! | [`SuperloopCycleThread`] | of a [`Time`], such as a timer of the chip | in one thread | nothing |
//! | `ChronoCycleThread` | of the operating system, soft | a thread each | feature `std` |
//! | `RtPreemptCycleThread` | of Linux, real-time priorities | a thread each | feature `linux-rt` |
//!
//! ```
//! use ceid_core::prelude::*;
//! use ceid_core::thread::{SimulatedCycleThread, Task, Until};
//! use core::time::Duration;
//!
//! # struct LowPass { input: f64, output: f64 }
//! # impl<R: Rate> SampledFilter<R> for LowPass {
//! #     fn update(&mut self, tick: Tick<'_, R>) { self.output += (self.input - self.output) * tick.dt() / 0.05; }
//! # }
//! filters! { struct Filters @ 1000 Hz { speed: LowPass } }
//!
//! struct Motor { control: Cyclic<Filters, Free<Hz<1000>>> }
//!
//! impl RealtimeFunctionality for Motor {
//!     type Rate = Hz<1000>;
//!
//!     fn cycle(&mut self, _: CycleInfo) -> Flow {
//!         let Some(mut guard) = self.control.cycle() else { return Flow::Stop };
//!         let f = guard.filters();
//!         f.speed.input = 1.0;
//!         Flow::Continue
//!     }
//! }
//!
//! let filters = Filters::register(LowPass { input: 0.0, output: 0.0 });
//! let mut motor = Task::new("motor", Motor { control: Cyclic::new(filters, Free::new()) }, Overrun::Skip);
//! SimulatedCycleThread::new().run(&mut [&mut motor], Until::duration(Duration::from_secs(7)));
//! assert_eq!((motor.cycles(), motor.missed()), (7000, 0));
//! ```
//!
//! # How a run goes
//!
//! Every world keeps these rules:
//!
//! - A run begins with release 0 of every task, at one common moment. Release `n` is due `n / HZ` seconds later, exactly.
//! - A run of duration `d` has the releases that are due before `d`: 1000 of them in a second at 1 kHz, and **none** if
//!   `d` is zero; then no functionality is called.
//! - **Stop request** ([`StopSignal`]): the cycle that is running is finished, no other begins. A task that waits for
//!   its release sees the request then, at most one period later.
//! - **End of one is end of all**: when a functionality returns [`Flow::Stop`], panics, or misses a release under
//!   [`Overrun::Stop`], the other tasks end in the same way as by a stop request. A robot does not go on with a
//!   part of it missing.
//! - **Panic in a cycle**: the guard of the cycle updates its filters, the functionality is never called again, the
//!   other tasks end, and then the panic goes on in the caller of [`run`](RealtimeThread::run).
//! - **Overrun**: if a cycle has not begun before the next release of its task, that is an overrun; what happens then is
//!   chosen per task, see [`Overrun`]. Cycles run + releases missed = releases.
//! - Why each task ended is its [`outcome`](Task::outcome).

#[cfg(feature = "std")]
#[forbid(unsafe_code)]
mod chrono;
#[forbid(unsafe_code)]
mod cooperative;
#[forbid(unsafe_code)]
mod histogram;
#[cfg(feature = "std")]
#[forbid(unsafe_code)]
mod privileges;
#[cfg(all(feature = "linux-rt", target_os = "linux"))]
#[forbid(unsafe_code)]
mod rt_preempt;
#[forbid(unsafe_code)]
mod simulated;
#[forbid(unsafe_code)]
mod superloop;
#[cfg(all(feature = "linux-rt", target_os = "linux"))]
#[expect(unsafe_code, reason = "the system calls of real-time threads")]
mod system_calls;
#[forbid(unsafe_code)]
mod task;
#[forbid(unsafe_code)]
mod until;
#[cfg(feature = "std")]
#[forbid(unsafe_code)]
mod workers;

#[cfg(feature = "std")]
pub use chrono::ChronoCycleThread;
pub use histogram::Histogram;
#[cfg(feature = "std")]
pub use privileges::{Granted, Privilege, Privileges};
#[cfg(all(feature = "linux-rt", target_os = "linux"))]
pub use rt_preempt::{IfRefused, RtPreemptCycleThread, Scheduling};
pub use simulated::SimulatedCycleThread;
pub use superloop::SuperloopCycleThread;
pub use task::{CyclicTask, Outcome, Task};
pub use until::{StopSignal, Until};

use crate::cycle::{CycleInfo, Free};
#[cfg(doc)]
use crate::cycle::{Overrun, Time};
use crate::rate::Rate;

/// What a robot does in each cycle, at one rate; independent of the thread that runs it.
///
/// Its filters are guarded in each call, with a clock ([`ClockOf`]) that leaves the pace to the thread. For filters that
/// cannot be reached past their guard, see [`OnlyInCeid`](crate::OnlyInCeid).
///
/// ```
/// use ceid_core::prelude::*;
///
/// # struct LowPass { input: f64, output: f64 }
/// # impl<R: Rate> SampledFilter<R> for LowPass { fn update(&mut self, _: Tick<'_, R>) { self.output = self.input; } }
/// struct Motor { clock: ClockOf<Self>, speed: LowPass }
///
/// impl RealtimeFunctionality for Motor {
///     type Rate = Hz<1000>;
///
///     fn cycle(&mut self, info: CycleInfo) -> Flow {
///         let cycle = self.clock.begin_cycle();
///         ceid!(cycle => speed = self.speed);
///         if info.missed > 0 {
///             return Flow::Continue;
///         }
///         speed.input = 1.0;
///         Flow::Continue
///     }
/// }
/// # let mut motor = Motor { clock: Free::new(), speed: LowPass { input: 0.0, output: 0.0 } };
/// # let _ = motor.cycle(CycleInfo::default());
/// # assert_eq!(motor.speed.output, 1.0);
/// ```
#[doc(alias = "RealtimeFunctionalityIF")]
pub trait RealtimeFunctionality: Send {
    /// The rate of the cycles.
    type Rate: Rate;

    /// Runs one cycle.
    ///
    /// Called by a [`RealtimeThread`], once per release that is not missed. It should neither block nor allocate, nor
    /// take longer than the period; see the [module](crate::thread) for what happens if it panics or overruns.
    fn cycle(&mut self, info: CycleInfo) -> Flow;
}

/// The clock of a functionality, for its filters: it leaves the pace to the thread, and its rate is that of the
/// functionality, so that no filter can be guarded at another one.
///
/// ```compile_fail,E0277
/// use ceid_core::prelude::*;
///
/// # struct LowPass { input: f64, output: f64 }
/// # impl<R: Rate> SampledFilter<R> for LowPass { fn update(&mut self, _: Tick<'_, R>) { self.output = self.input; } }
/// filters! { struct Filters @ 1000 Hz { speed: LowPass } }
///
/// struct Motor { clock: ClockOf<Self>, filters: Filters }
///
/// impl RealtimeFunctionality for Motor {
///     type Rate = Hz<100>; // the filters are made for 1000 Hz
///
///     fn cycle(&mut self, _: CycleInfo) -> Flow {
///         let cycle = self.clock.begin_cycle();
///         ceid!(cycle => f = self.filters);
///         f.speed.input = 1.0;
///         Flow::Continue
///     }
/// }
/// ```
pub type ClockOf<F> = Free<<F as RealtimeFunctionality>::Rate>;

/// Whether a functionality wants another cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[must_use]
pub enum Flow {
    /// Call it again at its next release.
    Continue,
    /// End the run, of all tasks.
    Stop,
}

/// A world that runs tasks cycle by cycle: see the table and the rules of the [module](crate::thread).
#[doc(alias = "RealtimeThreadIF")]
pub trait RealtimeThread {
    /// What the world has to say about the run: the privileges it was granted or refused, if it asks for any.
    type Report: core::fmt::Debug;

    /// Runs the tasks until one of them or `until` ends the run.
    ///
    /// Blocks for the whole run (in virtual time, only for as long as its cycles take). The loop does not
    /// allocate; threads of an operating system are made before it begins. What a run found out about a task is asked
    /// of the [`Task`] afterwards. A panic in a cycle goes on here, when the other tasks have ended.
    fn run(&mut self, tasks: &mut [&mut dyn CyclicTask], until: Until<'_>) -> Self::Report;
}
