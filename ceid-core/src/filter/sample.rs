//! The inbox of a filter: a measurement counts once. Nothing here knows where measurements come from.

use super::Tick;
use crate::rate::Rate;

/// An inbox for the newest measurement: the body of the cycle puts it in, the update law takes it out.
///
/// A measurement is used once. In a cycle without a new one the law gets `None`, and predicts only; it cannot take the
/// old value for a new one, because it has to say what it does without. And one that is replaced before any law has
/// seen it is handed back.
///
/// ```
/// use ceid_core::prelude::*;
///
/// struct Speed { odometer: Sample<f64>, estimate: f64 }
///
/// impl<R: Rate> SampledFilter<R> for Speed {
///     fn update(&mut self, tick: Tick<'_, R>) {
///         match self.odometer.take(&tick) {
///             Some(measured) => self.estimate += 0.1 * (measured - self.estimate),
///             None if self.odometer.age() > Some(100) => self.estimate = 0.0,
///             None => {}
///         }
///     }
/// }
///
/// let mut control = Cyclic::new(Speed { odometer: Sample::new(), estimate: 0.0 }, Free::<Hz<1000>>::new());
/// each_cycle!(speed, info in control => {
///     match info.n {
///         0 => assert_eq!(speed.odometer.put(10.0), None),
///         1 => assert_eq!(speed.estimate, 1.0),
///         _ => break,
///     }
/// });
/// assert_eq!(control.filters().odometer.age(), Some(2));
/// ```
///
/// Takes the space of an `Option<T>` and a counter. Its functions neither allocate, block nor panic, and take constant
/// time.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample<T> {
    newest: Option<T>,
    age: Option<u32>,
}

impl<T> Sample<T> {
    /// An empty inbox, which has never held a measurement. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn new() -> Self {
        Self { newest: None, age: None }
    }

    /// Puts a measurement in. Returns the one before, if no law has taken it: it is lost, unless the caller wants it.
    /// Neither allocates nor blocks nor panics.
    #[inline]
    pub fn put(&mut self, measurement: T) -> Option<T> {
        self.newest.replace(measurement)
    }

    /// Takes the measurement out, if there is a new one. Once per run of the law: only a law has a tick.
    /// Neither allocates nor blocks nor panics.
    // Compile errors quote the line of the function to a body that takes.
    #[rustfmt::skip]
    #[must_use = "a measurement that is taken is gone"]
    #[inline]
    pub fn take<R: Rate>(&mut self, _: &Tick<'_, R>) -> Option<T> { // only the update law has a tick: take the measurement there
        self.age = if self.newest.is_some() { Some(0) } else { self.age.map(|age| age.saturating_add(1)) };
        self.newest.take()
    }

    /// How many runs of the law ago a measurement was last taken: 0 for this one, `None` if there has been none yet.
    /// Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn age(&self) -> Option<u32> {
        self.age
    }

    /// Whether a measurement waits for the law. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub const fn is_fresh(&self) -> bool {
        self.newest.is_some()
    }
}

impl<T> Default for Sample<T> {
    fn default() -> Self {
        Self::new()
    }
}
