//! The driver: it owns the filters and their clock, and lets the filters be reached only inside a cycle.

use core::ops::ControlFlow;

use super::{Clock, CycleGuard, CycleInfo};
use crate::filter::SampledFilter;

/// Runs control cycles: owns a set of filters and the clock that releases its cycles.
///
/// The filters can be changed only inside a cycle, and every cycle has a guard, so no cycle can be entered without
/// their update. Three ways in, from the safest:
///
/// - [`each_cycle!`](crate::each_cycle): a loop with natural control flow, and a guard that has no name;
/// - [`run`](Cyclic::run): the same as a closure;
/// - [`cycle`](Cyclic::cycle): one cycle with a named guard, for loops that are not yours.
///
/// Owned by one thread at a time; `Send` if its parts are.
#[doc(alias = "CEID")]
#[derive(Debug)]
pub struct Cyclic<S, C> {
    filters: S,
    clock: C,
}

impl<C: Clock, S: SampledFilter<C::Rate>> Cyclic<S, C> {
    /// Joins filters and clock. Their rates must be the same type. No cycle begins yet.
    /// Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn new(filters: S, clock: C) -> Self {
        Self { filters, clock }
    }

    /// Waits for the next cycle, and returns its guard; `None` when the clock has ended.
    ///
    /// Keep the guard to the end of the cycle: see [`CycleGuard`]. Blocks as long as the clock does, does not allocate.
    ///
    /// ```
    /// use ceid_core::prelude::*;
    /// # struct KalmanF; impl KalmanF { fn measure(&mut self, _: f64) {} }
    /// # impl<R: Rate> SampledFilter<R> for KalmanF { fn update(&mut self, _: Tick<'_, R>) {} }
    /// # filters! { struct Filters @ 1000 Hz { kf: KalmanF } }
    ///
    /// // Called once per period by a framework.
    /// fn on_timer(control: &mut Cyclic<Filters, Free<Hz<1000>>>, position: f64) {
    ///     let Some(mut guard) = control.cycle() else { return };
    ///     let f = guard.filters();
    ///     f.kf.measure(position);
    /// }
    /// ```
    #[must_use = "the filters are updated when the guard is dropped: bind it, and keep it to the end of the cycle"]
    #[inline]
    pub fn cycle(&mut self) -> Option<CycleGuard<'_, S, C::Rate>> {
        let cycle = self.clock.next_cycle()?;
        Some(cycle.guard(&mut self.filters))
    }

    /// Runs `body` once per cycle, until it breaks or the clock ends. Returns the value it broke with, or `None`.
    ///
    /// Blocks as long as the clock does in each cycle, does not allocate, and takes the time of its bodies and laws.
    ///
    /// ```
    /// use ceid_core::prelude::*;
    /// use core::ops::ControlFlow::{Break, Continue};
    /// # struct KalmanF; impl KalmanF { fn estimate(&self) -> f64 { 1.0 } }
    /// # impl<R: Rate> SampledFilter<R> for KalmanF { fn update(&mut self, _: Tick<'_, R>) {} }
    /// # filters! { struct Filters @ 1000 Hz { kf: KalmanF } }
    ///
    /// let mut control = Cyclic::new(Filters::register(KalmanF), Free::<Hz<1000>>::new());
    /// let reached = control.run(|f, info| if f.kf.estimate() > 0.5 { Break(info.n) } else { Continue(()) });
    /// assert_eq!(reached, Some(0));
    /// ```
    #[inline]
    pub fn run<B>(&mut self, mut body: impl FnMut(&mut S, CycleInfo) -> ControlFlow<B>) -> Option<B> {
        while let Some(mut guard) = self.cycle() {
            let info = guard.info();
            if let ControlFlow::Break(value) = body(guard.filters(), info) {
                return Some(value);
            }
        }
        None
    }

    /// The filters between two cycles, for reading. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn filters(&self) -> &S {
        &self.filters
    }

    /// The clock, for reading. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn clock(&self) -> &C {
        &self.clock
    }

    /// Gives filters and clock back, after the last cycle. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub fn into_parts(self) -> (S, C) {
        (self.filters, self.clock)
    }

    /// Borrows the driver, whether it is owned or itself a `&mut` reference; for [`each_cycle!`](crate::each_cycle).
    /// Neither allocates nor blocks nor panics.
    #[inline]
    pub const fn by_ref(&mut self) -> &mut Self {
        self
    }
}
