//! Filters with several users, found out at run time: the one check that types cannot make. Neither threads nor cycles
//! are known here.

use core::cell::{Cell, RefCell};
use core::fmt;
use core::ops::Deref;

use super::{SampledFilter, Tick};
use crate::rate::Rate;

/// A filter that several parts of a program use, and that one set updates.
///
/// Who uses it is often known only at run time: plug-ins, a configuration file, a list of sensors. Then the borrow
/// checker cannot tell whether a filter is registered twice, and this type checks it: [`try_register`] succeeds once, and
/// again only after that registration is gone. Where the paper's `UniqueCheck` (Figure A4) compares all pointers of
/// one guard in every cycle, this is one flag, looked at when a filter is registered, and it sees the registrations
/// of all guards.
///
/// ```
/// use ceid_core::Shared;
/// use ceid_core::prelude::*;
/// use std::rc::Rc;
/// # struct KalmanF(f64);
/// # impl KalmanF { fn measure(&mut self, z: f64) { self.0 = z } }
/// # impl<R: Rate> SampledFilter<R> for KalmanF { fn update(&mut self, _: Tick<'_, R>) {} }
///
/// let kf = Rc::new(Shared::new(KalmanF(0.0)));
/// let camera = Rc::clone(&kf);
///
/// let registration = Shared::try_register(Rc::clone(&kf))?;
/// assert!(Shared::try_register(kf).is_err(), "it is updated already");
///
/// let mut control = Cyclic::new([registration], Free::<Hz<1000>>::new().take(10));
/// each_cycle!(_f in control => { camera.with(|kf| kf.measure(0.5)) });
/// # Ok::<(), ceid_core::filter::AlreadyRegistered>(())
/// ```
///
/// For one thread; between threads, values travel and not filters. Its functions neither allocate nor block, and take
/// constant time.
///
/// [`try_register`]: Shared::try_register
#[doc(alias = "UniqueCheck")]
#[derive(Debug, Default)]
pub struct Shared<F: ?Sized> {
    is_registered: Cell<bool>,
    filter: RefCell<F>,
}

impl<F> Shared<F> {
    /// A filter that nothing updates yet. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn new(filter: F) -> Self {
        Self { is_registered: Cell::new(false), filter: RefCell::new(filter) }
    }
}

impl<F: ?Sized> Shared<F> {
    /// Registers the filter: what is returned goes into a set, and the guard of that set updates the filter.
    ///
    /// `handle` is whatever leads to it: `&Shared`, `Rc<Shared>`.
    ///
    /// # Errors
    ///
    /// [`AlreadyRegistered`] if a registration of this filter exists, through any handle.
    /// Neither allocates nor blocks nor panics.
    #[inline]
    pub fn try_register<H: Deref<Target = Self>>(handle: H) -> Result<Registration<H>, AlreadyRegistered> {
        if handle.is_registered.replace(true) { Err(AlreadyRegistered) } else { Ok(Registration { handle }) }
    }

    /// Lends the filter to `body`, to feed or to read it. A closure, so that no borrow outlives the cycle.
    ///
    /// # Panics
    ///
    /// If `body` lends the same filter again, or ends a cycle that updates it.
    /// Otherwise neither allocates nor blocks by itself.
    #[inline]
    #[track_caller]
    pub fn with<T>(&self, body: impl FnOnce(&mut F) -> T) -> T {
        match self.filter.try_borrow_mut() {
            Ok(mut filter) => body(&mut filter),
            Err(_) => {
                panic!("a shared filter is used or updated inside `Shared::with` of itself: end that closure first")
            }
        }
    }

    /// Whether a set updates this filter. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub fn is_registered(&self) -> bool {
        self.is_registered.get()
    }
}

/// The registration of a [`Shared`] filter: the filter, as its set sees it. Ends when it is dropped.
#[must_use = "a registration that is dropped is over: put it into a set"]
pub struct Registration<H: Deref<Target: Registrable>> {
    handle: H,
}

/// Says that a handle leads to a [`Shared`] filter, of whatever type.
#[doc(hidden)]
pub trait Registrable {
    /// Lets the filter be registered again.
    fn end_registration(&self);
}

impl<F: ?Sized> Registrable for Shared<F> {
    #[inline]
    fn end_registration(&self) {
        self.is_registered.set(false);
    }
}

impl<H: Deref<Target: Registrable>> Drop for Registration<H> {
    #[inline]
    fn drop(&mut self) {
        self.handle.end_registration();
    }
}

#[diagnostic::do_not_recommend]
impl<R: Rate, H: Deref<Target = Shared<F>>, F: SampledFilter<R> + ?Sized> SampledFilter<R> for Registration<H> {
    #[inline]
    fn update(&mut self, tick: Tick<'_, R>) {
        self.handle.with(|filter| filter.update(tick));
    }
}

impl<H: Deref<Target: Registrable>> fmt::Debug for Registration<H> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Registration").finish_non_exhaustive()
    }
}

/// The filter has a registration already: a second one would run its law twice per cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AlreadyRegistered;

impl fmt::Display for AlreadyRegistered {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the filter is registered already: a second registration would run its law twice per cycle")
    }
}

impl core::error::Error for AlreadyRegistered {}
