//! Filters that cannot be used before they are registered. Nothing here knows a cycle.

use core::array;
use core::fmt;
use core::marker::PhantomData;
use core::mem::ManuallyDrop;

use super::{OnlyInCeid, Register};

/// A filter that is born unusable, and becomes usable by registration.
///
/// A filter type whose constructors return `Unregistered<Self>` cannot be overlooked: nothing can be done with the
/// value but registering it, in a set of [`filters!`](crate::filters) or, with
/// [`only_in_ceid`](Unregistered::only_in_ceid), for [`ceid!`](crate::ceid). Feeding it, reading it or calling its law is
/// a compile error that names `Unregistered<YourFilter>`.
///
/// ```
/// use ceid_core::prelude::*;
///
/// pub struct KalmanF { estimate: f64 }
///
/// impl KalmanF {
///     pub const fn new() -> Unregistered<Self> {
///         Unregistered::new(Self { estimate: 0.0 })
///     }
/// }
/// # impl<R: Rate> SampledFilter<R> for KalmanF { fn update(&mut self, _: Tick<'_, R>) {} }
///
/// filters! { struct Filters @ 1000 Hz { kf: KalmanF } }
/// let filters = Filters::register(KalmanF::new());
/// ```
///
/// # A value that must be used
///
/// In programs built with `panic = "abort"` (all bare-metal ones are), a path on which an `Unregistered` is dropped is
/// a build error too, in debug and in release: "a sampled-time filter is built but never registered". This is the
/// feature `must-register`, on by default. What to know about it:
///
/// - The error names the type of the filter, not the line: it is found when code is generated. So `cargo build`
///   shows it, and `cargo check` and editors do not.
/// - A `?` or `return` between construction and registration drops the filter on that path. Write the constructors
///   inside `register(...)`.
/// - A `Vec` or an array of `Unregistered` could always be dropped. Collect into an `Unregistered<Vec<_>>`, or use
///   [`Unregistered::array`].
/// - With `panic = "unwind"`, and so in `cargo test`, every call that may panic could drop the filter: there the
///   compiler only warns of a value that is never used.
/// - `mem::forget` and a `static` escape it.
///
/// It takes no space beside the filter. Its functions do not allocate, block or panic beyond what the closures and
/// collections given to them do.
#[must_use = "a filter that is built but never registered is never updated: pass it to `register` of its set"]
pub struct Unregistered<F> {
    filter: F,
    duty: DutyToRegister<F>,
}

/// What an [`Unregistered`] owes. Apart from it, because a type with a destructor cannot be taken apart.
struct DutyToRegister<F>(PhantomData<F>);

#[cfg(all(feature = "must-register", panic = "abort"))]
impl<F> Drop for DutyToRegister<F> {
    #[inline]
    fn drop(&mut self) {
        const { panic!("a sampled-time filter is built but never registered: pass it to `register` of its set") }
    }
}

/// Implemented by nothing, for its message.
#[doc(hidden)]
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be listed in `ceid!`",
    label = "lists a filter that is not registered",
    note = "for `ceid!`, append `.only_in_ceid()` to the constructor: the filter can then be reached only below its `ceid!`",
    note = "for `each_cycle!`, pass the filter to `register` of its set"
)]
pub trait MadeForCeid {}

impl<F> Unregistered<F> {
    /// For the constructors of a filter type. Neither allocates nor blocks nor panics.
    #[inline]
    pub const fn new(filter: F) -> Self {
        Self { filter, duty: DutyToRegister(PhantomData) }
    }

    /// Prepares the filter for a loop that [`ceid!`](crate::ceid) guards: it can be reached only below its `ceid!`.
    /// Neither allocates nor blocks nor panics.
    #[inline]
    pub fn only_in_ceid(self) -> OnlyInCeid<F> {
        OnlyInCeid::new(self.discharge())
    }

    /// Builds a composite around the filter, which then has to be registered in its place.
    /// Allocates, blocks and panics as `build` does.
    #[inline]
    pub fn map<G>(self, build: impl FnOnce(F) -> G) -> Unregistered<G> {
        Unregistered::new(build(self.discharge()))
    }

    /// Joins two filters, to build a composite of both with [`map`](Unregistered::map).
    /// Neither allocates nor blocks nor panics.
    #[inline]
    pub fn zip<G>(self, other: Unregistered<G>) -> Unregistered<(F, G)> {
        let (first, second) = (self.discharge(), other.discharge());
        Unregistered::new((first, second))
    }

    /// What [`ceid!`](crate::ceid) calls on each name of its list; here it never compiles, and says why.
    #[doc(hidden)]
    pub fn guarded_at<R>(&mut self, _: PhantomData<R>) -> &mut F
    where
        Self: MadeForCeid,
    {
        &mut self.filter
    }

    #[inline]
    pub(super) fn discharge(self) -> F {
        let Self { filter, duty } = self;
        let _ = ManuallyDrop::new(duty);
        filter
    }
}

impl<F, const N: usize> Unregistered<[F; N]> {
    /// Builds an array of filters, one for each index from 0.
    ///
    /// ```
    /// # use ceid_core::prelude::*;
    /// # struct Pid(usize);
    /// # impl Pid { fn new(axis: usize) -> Unregistered<Self> { Unregistered::new(Self(axis)) } }
    /// # impl<R: Rate> SampledFilter<R> for Pid { fn update(&mut self, _: Tick<'_, R>) {} }
    /// filters! { struct Filters @ 1000 Hz { axes: [Pid; 3] } }
    /// let filters = Filters::register(Unregistered::array(Pid::new));
    /// ```
    ///
    /// Allocates, blocks and panics as `build` does.
    #[inline]
    pub fn array(mut build: impl FnMut(usize) -> Unregistered<F>) -> Self {
        Self::new(array::from_fn(|index| build(index).discharge()))
    }
}

/// A collection of filters: `(0..n).map(Pid::new).collect::<Unregistered<Vec<_>>>()`.
impl<F, C: FromIterator<F>> FromIterator<Unregistered<F>> for Unregistered<C> {
    fn from_iter<I: IntoIterator<Item = Unregistered<F>>>(filters: I) -> Self {
        Self::new(filters.into_iter().map(Unregistered::discharge).collect())
    }
}

impl<F> Register<F> for Unregistered<F> {
    #[inline]
    fn registered(self) -> F {
        self.discharge()
    }
}

impl<F> fmt::Debug for Unregistered<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Unregistered").finish_non_exhaustive()
    }
}
