//! Sampled-time filters: the update law, the permit to run it, and what may hold filters. Nothing here decides when a
//! cycle begins or ends.

#![forbid(unsafe_code)]

mod adapted;
mod divider;
#[cfg(feature = "alloc")]
mod heap;
mod holders;
mod register;
mod sample;
mod set;
mod shared;
mod tick;
mod unregistered;

pub use adapted::Adapted;
pub use divider::Divider;
pub use register::{OnlyInCeid, Register};
pub use sample::Sample;
pub use set::{Field, Registers, divided_rate, field_name_hash, is_registered_once};
pub use shared::{AlreadyRegistered, Registration, Shared};
pub use tick::Tick;
pub use unregistered::Unregistered;

use crate::rate::Rate;

/// An algorithm with internal state that advances by one sample per control cycle: a Kalman filter, a particle filter,
/// a controller, a finite-state automaton.
///
/// `update` is its update law. Only a guard of this crate calls it, once per cycle, because only the crate can make the
/// [`Tick`] it takes: where the paper makes `update` private and the guard a friend (Figure A3), here the argument
/// cannot be had.
///
/// Everything else about the filter (feeding measurements, reading estimates, resetting) is ordinary methods and fields
/// of your type.
///
/// # Which rate
///
/// A law that reads its step from the tick works at every rate:
///
/// ```
/// use ceid_core::prelude::*;
///
/// struct Integrator { rate_of_change: f64, value: f64 }
///
/// impl<R: Rate> SampledFilter<R> for Integrator {
///     fn update(&mut self, tick: Tick<'_, R>) {
///         self.value += self.rate_of_change * tick.dt();
///     }
/// }
/// ```
///
/// A law with coefficients designed for one rate says so, and cannot be registered at another:
///
/// ```
/// # use ceid_core::prelude::*;
/// # struct Notch;
/// impl SampledFilter<Hz<100>> for Notch {
///     fn update(&mut self, _: Tick<'_, Hz<100>>) { /* coefficients for 100 Hz */ }
/// }
/// ```
///
/// # Filters made of filters
///
/// Tuples, arrays, slices, `Option`, `&mut F`, sets made by [`filters!`](crate::filters), and with the feature `alloc`
/// `Vec` and `Box`, are filters too. A composite of your own passes the tick on with [`Tick::then`] and [`Tick::each`].
///
/// Shared handles (`Rc`, `Arc`, `&RefCell`, `&Mutex`) are not: two handles of one filter could be registered, and its
/// law would run twice per cycle. A filter that really is shared is registered with [`Shared::try_register`].
#[doc(alias = "sampled-time filter")]
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a sampled-time filter at the rate `{R}`",
    label = "has no update law for this rate",
    note = "a law that works at every rate: `impl<R: Rate> SampledFilter<R> for ...`",
    note = "a law designed for another rate: register it in a set of that rate, or with `every N` in a faster set",
    note = "a shared handle (`Rc`, `Arc`, `&RefCell`, `&Mutex`) is never a filter, because two handles could run one law twice in a cycle: let the set own the filter, or register it with `Shared::try_register`"
)]
pub trait SampledFilter<R: Rate> {
    /// Advances the state by one sample.
    ///
    /// Called by the guard at the end of each cycle. The body runs on the control path, so it should neither block nor
    /// allocate. A panic in it leaves the laws after it in the same cycle unrun.
    // The line below is what compile errors quote when a law is called by hand.
    fn update(&mut self, tick: Tick<'_, R>); // only a guard has a tick: register the filter with `filters!` or `ceid!`
}
