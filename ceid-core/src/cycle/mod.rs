//! The control cycle: who starts it (a clock), who owns the filters (a driver), and who updates them at its end (a
//! guard). Nothing here knows what a filter does, or how a clock waits.

#![forbid(unsafe_code)]

mod clock;
mod driver;
mod guard;
mod macros;
mod periodic;
mod release;
#[cfg(feature = "std")]
mod std_time;

pub use clock::{Clock, CycleInfo, Free, Take};
pub use driver::Cyclic;
pub use guard::{Cycle, CycleGuard, Guarded};
pub use periodic::{Periodic, Time};
pub use release::{Overrun, Releases};
#[cfg(feature = "std")]
pub use std_time::StdTime;
