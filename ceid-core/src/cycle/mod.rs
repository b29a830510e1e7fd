//! The control cycle: who starts it (a clock), who owns the filters (a driver), and who updates them at its end (a
//! guard). Nothing here knows what a filter does, or how a clock waits.

mod clock;
mod driver;
mod guard;
mod macros;

pub use clock::{Clock, CycleInfo, Free, Take};
pub use driver::Cyclic;
pub use guard::{Cycle, CycleGuard, Guarded};
