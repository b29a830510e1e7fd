//! What `register` of a set takes, and what becomes of filters that have no set.

use core::fmt;
use core::marker::PhantomData;

/// What may be passed to `register` where a set of [`filters!`](crate::filters) declares a filter of type `F`: the
/// filter itself, or an [`Unregistered<F>`](crate::Unregistered).
#[diagnostic::on_unimplemented(
    message = "the set declares a `{F}` here, and this is a `{Self}`",
    label = "not a `{F}`",
    note = "`register` takes the filters in the order of their declaration in `filters!`, each as itself or as `Unregistered`"
)]
pub trait Register<F> {
    /// Gives the filter to its set; called by the code of `filters!`.
    #[doc(hidden)]
    fn registered(self) -> F;
}

impl<F> Register<F> for F {
    #[inline]
    fn registered(self) -> F {
        self
    }
}

/// A filter, or a set of them, that can be reached only below the [`ceid!`](crate::ceid) that lists it.
///
/// Leaving it out of the list is a compile error wherever the body uses it. A filter becomes one by
/// [`Unregistered::only_in_ceid`](crate::Unregistered::only_in_ceid), a set of [`filters!`](crate::filters) by
/// [`OnlyInCeid::new`].
///
/// ```
/// use ceid_core::prelude::*;
/// # struct KalmanF(f64);
/// # impl KalmanF { fn new() -> Unregistered<Self> { Unregistered::new(Self(0.0)) } }
/// # impl KalmanF { fn measure(&mut self, _: f64) {} fn estimate(&self) -> f64 { self.0 } }
/// # impl<R: Rate> SampledFilter<R> for KalmanF { fn update(&mut self, _: Tick<'_, R>) {} }
///
/// let mut kf = KalmanF::new().only_in_ceid();
/// let mut clock = Free::<Hz<1000>>::new().take(10);
/// while let Some(cycle) = clock.next_cycle() {
///     ceid!(cycle => kf);
///     kf.measure(0.0);
/// }
/// assert_eq!(kf.filter().estimate(), 0.0);
/// ```
///
/// Its functions neither allocate, block nor panic.
pub struct OnlyInCeid<F> {
    filter: F,
}

impl<F> OnlyInCeid<F> {
    /// Shuts a filter in, or a whole set: `OnlyInCeid::new(Filters::register(...))`.
    /// Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn new(filter: F) -> Self {
        Self { filter }
    }

    /// The filter between two cycles, for reading. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn filter(&self) -> &F {
        &self.filter
    }

    /// What [`ceid!`](crate::ceid) calls on each name of its list. Whether the filter has a law for the rate is asked
    /// where the rate is known, by the guard: asked here, the compiler would tell of mismatched types.
    #[doc(hidden)]
    #[inline]
    pub fn guarded_at<R>(&mut self, _: PhantomData<R>) -> &mut F {
        &mut self.filter
    }
}

impl<F> fmt::Debug for OnlyInCeid<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OnlyInCeid").finish_non_exhaustive()
    }
}
