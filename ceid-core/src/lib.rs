#![doc = include_str!("../README.md")]
#![no_std]
// The three modules that need `unsafe` say so where they are declared; in every other file it is an error.
#![deny(unsafe_code)]
#![deny(missing_docs)]
#![warn(clippy::std_instead_of_core, clippy::alloc_instead_of_core)]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(any(feature = "std", test))]
extern crate std;

#[forbid(unsafe_code)]
pub mod cycle;
pub mod exchange;
#[forbid(unsafe_code)]
pub mod filter;
#[forbid(unsafe_code)]
pub mod rate;
pub mod thread;
#[forbid(unsafe_code)]
pub mod transaction;

pub use cycle::{Clock, Cycle, CycleGuard, CycleInfo, Cyclic, Free, Take};
pub use filter::{Divider, SampledFilter, Tick};
pub use rate::{Hz, Rate};
pub use thread::{Flow, RealtimeFunctionality, RealtimeThread};
pub use transaction::TransactionIo;

/// Everything a control loop needs, for `use ceid_core::prelude::*;`.
pub mod prelude {
    pub use crate::{Clock, CycleInfo, Cyclic, Free, Hz, Rate, SampledFilter, Tick};
    pub use crate::{Flow, RealtimeFunctionality, RealtimeThread};
    pub use crate::{assert_updated_once, ceid, each_cycle, filters};
}

/// What the macros of this crate expand to; not for use by hand.
#[doc(hidden)]
pub mod __private {
    pub use crate::cycle::Guarded;
    pub use crate::filter::{Field, divided_rate, field_name_hash, is_registered_once};
}
