//! The guard that updates filters at the end of a cycle, and the token it is made from. Neither reads a clock.

use core::fmt;
use core::marker::PhantomData;

use super::CycleInfo;
use crate::filter::{SampledFilter, Tick};
use crate::rate::Rate;

/// One control cycle that has begun: the token from which one guard can be made.
///
/// Comes from [`Clock::next_cycle`](crate::Clock::next_cycle) and goes into [`ceid!`](crate::ceid). It is moved there,
/// so a second guard in the same cycle does not compile; and it borrows the clock, so the next cycle cannot begin
/// before the guard of this one has done its work.
#[must_use = "a cycle that is not passed to `ceid!` updates no filter"]
pub struct Cycle<'c, R> {
    info: CycleInfo,
    clock: PhantomData<(&'c mut (), R)>,
}

impl<'c, R: Rate> Cycle<'c, R> {
    #[inline]
    pub(super) fn new(info: CycleInfo) -> Self {
        Self { info, clock: PhantomData }
    }

    /// What the clock says about this cycle. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub fn info(&self) -> CycleInfo {
        self.info
    }

    #[doc(hidden)]
    #[inline]
    pub const fn rate(&self) -> PhantomData<R> {
        PhantomData
    }

    /// What [`ceid!`](crate::ceid) asks of each of several filters, so that a compile error names the one without a law
    /// for the rate.
    #[doc(hidden)]
    #[inline]
    pub fn admit<'f, F: SampledFilter<R> + ?Sized>(&self, filter: &'f mut F) -> &'f mut F {
        filter
    }

    /// Makes the guard of this cycle: the filters are updated when it is dropped.
    ///
    /// Prefer [`ceid!`](crate::ceid), whose guard has no name and so can be neither dropped early nor forgotten.
    /// Neither allocates nor blocks nor panics.
    #[inline]
    pub fn guard<S: SampledFilter<R> + ?Sized>(self, filters: &'c mut S) -> CycleGuard<'c, S, R> {
        CycleGuard { filters, info: self.info, rate: PhantomData }
    }
}

/// What [`ceid!`](crate::ceid) calls on each name of its list: a method, so that it borrows variables and references
/// alike, and so that compile errors point at the name.
#[doc(hidden)]
pub trait Guarded<R: Rate>: SampledFilter<R> {
    /// Borrows the filter for one cycle.
    #[inline]
    fn guarded_at(&mut self, _: PhantomData<R>) -> &mut Self {
        self
    }
}

impl<R: Rate, F: SampledFilter<R> + ?Sized> Guarded<R> for F {}

impl<R: Rate> fmt::Debug for Cycle<'_, R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Cycle").field("info", &self.info).finish()
    }
}

/// Updates its filters once, in order, when it is dropped: the destructor of the paper (Figures 6, A2 and A5).
///
/// Because it is a destructor, the laws run on every way out of the cycle: the end of the body, `continue`, `break`,
/// `return`, `?`, and a panic. During a panic they run on whatever inputs the body has left; a law that then panics
/// itself aborts the program.
///
/// This is the primitive, for loops that are not yours (an interrupt task, a callback). It has to live to the end of
/// the cycle, and the language cannot check that: `mem::forget` it, and no law runs; `let _ =` it, and the laws run
/// too early. The macros [`each_cycle!`](crate::each_cycle) and [`ceid!`](crate::ceid) and the closure form
/// [`Cyclic::run`](crate::Cyclic::run) have no such gap.
#[doc(alias = "CEID")]
#[must_use = "the filters are updated when the guard is dropped: bind it with `let mut guard = ...`, and keep it to the end of the cycle"]
// Without `#[clippy::has_significant_drop]`, by which clippy would ask for dropping it early.
pub struct CycleGuard<'c, S: SampledFilter<R> + ?Sized, R: Rate> {
    filters: &'c mut S,
    info: CycleInfo,
    rate: PhantomData<R>,
}

impl<S: SampledFilter<R> + ?Sized, R: Rate> CycleGuard<'_, S, R> {
    /// The filters, as one plain reference, so that their fields can be borrowed side by side.
    /// Neither allocates nor blocks nor panics.
    #[inline]
    pub fn filters(&mut self) -> &mut S {
        self.filters
    }

    /// What the clock says about this cycle. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub fn info(&self) -> CycleInfo {
        self.info
    }
}

impl<S: SampledFilter<R> + ?Sized, R: Rate> Drop for CycleGuard<'_, S, R> {
    #[inline]
    fn drop(&mut self) {
        self.filters.update(Tick::new());
    }
}

impl<S: SampledFilter<R> + ?Sized, R: Rate> fmt::Debug for CycleGuard<'_, S, R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CycleGuard").field("info", &self.info).finish_non_exhaustive()
    }
}
