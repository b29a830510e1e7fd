#![cfg_attr(feature = "std", doc = include_str!("../README.md"))]
#![cfg_attr(
    not(feature = "std"),
    doc = "Sampled-time filters whose update law runs exactly once per control cycle: see the README."
)]
#![no_std]
// The three files that need `unsafe` say so where they are declared; all others forbid it.
#![deny(unsafe_code)]
#![deny(missing_docs)]
#![warn(clippy::std_instead_of_core, clippy::alloc_instead_of_core)]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

pub mod cycle;
pub mod exchange;
pub mod filter;
pub mod rate;
pub mod thread;
#[forbid(unsafe_code)]
pub mod transaction;

#[cfg(feature = "std")]
pub use cycle::StdTime;
pub use cycle::{Clock, Cycle, CycleGuard, CycleInfo, Cyclic, Free, Overrun, Periodic, Releases, Take, Time};
pub use filter::{Adapted, Divider, OnlyInCeid, Sample, SampledFilter, Shared, Tick, Unregistered};
pub use rate::{Hz, Rate};
pub use thread::{ClockOf, Flow, RealtimeFunctionality, RealtimeThread};
pub use transaction::TransactionIo;

/// Everything a control loop needs, for `use ceid_core::prelude::*;`.
pub mod prelude {
    #[cfg(feature = "std")]
    pub use crate::StdTime;
    pub use crate::{
        Adapted, Clock, CycleInfo, Cyclic, Free, Hz, OnlyInCeid, Overrun, Periodic, Rate, Sample, SampledFilter, Tick,
        Unregistered,
    };
    pub use crate::{ClockOf, Flow, RealtimeFunctionality, RealtimeThread};
    pub use crate::{assert_updated_once, ceid, each_cycle, filters};
}

/// What the macros of this crate expand to; not for use by hand.
#[doc(hidden)]
pub mod __private {
    pub use crate::cycle::Guarded;
    pub use crate::filter::{Field, divided_rate, field_name_hash, is_registered_once};
}
