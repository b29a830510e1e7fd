//! The permit to run an update law. It cannot be made outside this crate, copied, or kept.

use core::fmt;
use core::marker::PhantomData;

use super::{Divider, SampledFilter};
use crate::rate::Rate;

/// The permit to run one update law once, and the only source of its step `dt`.
///
/// A tick is made by the guard at the end of a cycle. It is passed by value, cannot be cloned or stored, and has no
/// public constructor; so an update law can be run neither by hand nor twice. It takes no space at run time.
///
/// A composite filter passes its tick on to its parts:
///
/// ```
/// use ceid_core::prelude::*;
/// # struct Pid;
/// # impl<R: Rate> SampledFilter<R> for Pid { fn update(&mut self, _: Tick<'_, R>) {} }
///
/// struct Attitude { estimate: Pid, axes: [Pid; 3] }
///
/// impl<R: Rate> SampledFilter<R> for Attitude {
///     fn update(&mut self, tick: Tick<'_, R>) {
///         tick.then(&mut self.estimate).each(&mut self.axes).done();
///     }
/// }
/// ```
///
/// The chain borrows every part until its end, so naming a part twice is a compile error. Leaving one out is not:
/// [`filters!`](crate::filters) cannot leave one out, and the linter's rule `missed_update` finds it elsewhere.
#[doc(alias = "friend class CEID")]
pub struct Tick<'p, R> {
    // Covariant in `'p`, so that a chain shrinks to the shortest borrow of its parts; neither `Send` nor `Sync`,
    // because the cycle that the tick belongs to is on this thread.
    parts: PhantomData<(&'p (), *const (), R)>,
}

impl<'p, R: Rate> Tick<'p, R> {
    // Compile errors quote the next line to whoever calls this.
    #[rustfmt::skip]
    #[inline]
    pub(crate) const fn new() -> Self { // only a guard makes ticks: register the filter with `filters!` or `ceid!`
        Self { parts: PhantomData }
    }

    /// The nominal time since the previous run of this law, in seconds. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn dt(&self) -> f64 {
        R::DT
    }

    /// The nominal time since the previous run of this law, in seconds, for targets without fast `f64`.
    /// Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn dt_f32(&self) -> f32 {
        R::DT_F32
    }

    /// The nominal rate of this law, in runs per second. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn hz(&self) -> u32 {
        R::HZ
    }

    /// Updates one part of a composite, now, and keeps the chain going.
    /// Allocates, blocks and panics as the law does: not at all by itself.
    #[inline]
    pub fn then<F: SampledFilter<R> + ?Sized>(self, part: &'p mut F) -> Self {
        part.update(Tick::new());
        self
    }

    /// Updates every part of a collection, now and in its order: `tick.each(&mut self.axes)`.
    /// Allocates, blocks and panics as the laws do: not at all by itself. Takes the time of one law for each part.
    #[inline]
    pub fn each<F, I>(self, parts: I) -> Self
    where
        F: SampledFilter<R> + ?Sized + 'p,
        I: IntoIterator<Item = &'p mut F>,
    {
        for part in parts {
            part.update(Tick::new());
        }
        self
    }

    /// Updates a part that runs at a slower rate, if this is one of its cycles.
    ///
    /// The slower rate must divide the rate of this tick; anything else is a compile error, shown by `cargo build`
    /// (in [`filters!`](crate::filters), by `cargo check` as well).
    /// Allocates, blocks and panics as the law does: not at all by itself.
    #[inline]
    pub fn every<S, F>(self, divider: &mut Divider<S>, part: &'p mut F) -> Self
    where
        S: Rate,
        F: SampledFilter<S> + ?Sized,
    {
        if divider.is_due::<R>() {
            part.update(Tick::new());
        }
        self
    }

    /// Ends a chain of parts. Neither allocates nor blocks nor panics.
    #[inline]
    pub fn done(self) {}
}

impl<R: Rate> fmt::Debug for Tick<'_, R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Tick({} Hz)", R::HZ)
    }
}
