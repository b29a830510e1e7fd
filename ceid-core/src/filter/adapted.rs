//! Laws that have another form than `SampledFilter::update`: with inputs, of another crate, or in several calls. Knows
//! nothing of when the law runs.

use core::fmt;
use core::ops::{Deref, DerefMut};

use super::{Sample, SampledFilter, Tick};
use crate::rate::Rate;

/// A filter whose law has another form, borrowed for a loop that a guard watches over.
///
/// For filters of other crates, laws that take inputs, and laws of several calls: the law is a closure. The body of the
/// cycle feeds it, and the guard runs it at the end of the cycle.
///
/// ```
/// use ceid_core::prelude::*;
///
/// struct Pid { sum: f64 }
///
/// impl Pid {
///     fn step(&mut self, error: f64) -> f64 { self.sum += error; 0.5 * self.sum }
/// }
///
/// let mut pid = Pid { sum: 0.0 };
/// let mut clock = Free::<Hz<1000>>::new().take(3);
/// let mut fed_pid = Adapted::fed(&mut pid, |pid, error| pid.step(error));
/// let mut outputs = [0.0; 3];
/// while let Some(cycle) = clock.next_cycle() {
///     let n = cycle.info().n as usize;
///     ceid!(cycle => pid = fed_pid);
///     outputs[n] = pid.feed(2.0).unwrap_or(-1.0);
/// }
/// assert_eq!(outputs, [-1.0, 1.0, 2.0]);
/// assert_eq!(pid.sum, 6.0);
/// ```
///
/// Everything else about the filter is reached through this type, which is a reference to it. Where the filter has a
/// method `feed` or `last_output` of its own, `(**pid).feed()` calls it.
///
/// An input is used once, as in a [`Sample`]: in a cycle that feeds nothing the law has nothing to run with, and does not
/// run. The linter finds such cycles (`skipped_update`). A filter of your own that can do better without an input
/// holds a [`Sample`] itself, and implements [`SampledFilter`].
///
/// Its functions neither allocate, block nor panic beyond what the law does.
pub struct Adapted<'f, F: ?Sized, L, N, O> {
    filter: &'f mut F,
    law: L,
    /// A `Sample` of the inputs; `()` if the law takes none.
    inbox: N,
    output: Option<O>,
}

impl<'f, F: ?Sized, L, O> Adapted<'f, F, L, (), O>
where
    L: FnMut(&mut F) -> O,
{
    /// A filter whose law takes no input, and runs in every cycle. Neither allocates nor blocks nor panics.
    ///
    /// ```
    /// use ceid_core::prelude::*;
    ///
    /// struct Button { polls: u32 }
    ///
    /// impl Button {
    ///     fn poll(&mut self) { self.polls += 1 }
    /// }
    ///
    /// let mut button = Button { polls: 0 };
    /// let mut clock = Free::<Hz<100>>::new().take(5);
    /// let mut adapted_button = Adapted::new(&mut button, |button| button.poll());
    /// while let Some(cycle) = clock.next_cycle() {
    ///     ceid!(cycle => button = adapted_button);
    /// }
    /// assert_eq!(button.polls, 5);
    /// ```
    #[must_use]
    #[inline]
    pub fn new(filter: &'f mut F, law: L) -> Self {
        Self { filter, law, inbox: (), output: None }
    }
}

impl<'f, F: ?Sized, L, I, O> Adapted<'f, F, L, Sample<I>, O>
where
    L: FnMut(&mut F, I) -> O,
{
    /// A filter whose law takes an input, or several as a tuple. Neither allocates nor blocks nor panics.
    #[must_use]
    #[inline]
    pub fn fed(filter: &'f mut F, law: L) -> Self {
        Self { filter, law, inbox: Sample::new(), output: None }
    }

    /// Gives the law its input for this cycle, in place of one that this cycle has given already. Returns what
    /// [`last_output`](Adapted::last_output) does. Neither allocates nor blocks nor panics.
    #[inline]
    pub fn feed(&mut self, input: I) -> Option<O> {
        self.inbox.put(input);
        self.last_output()
    }
}

impl<F: ?Sized, L, N, O> Adapted<'_, F, L, N, O> {
    /// Takes what the law gave back when it last ran, in the cycle before; `None` in the first cycle, and when it was taken
    /// already. Neither allocates nor blocks nor panics.
    #[inline]
    pub fn last_output(&mut self) -> Option<O> {
        self.output.take()
    }
}

#[diagnostic::do_not_recommend]
impl<R, F, L, O> SampledFilter<R> for Adapted<'_, F, L, (), O>
where
    R: Rate,
    F: ?Sized,
    L: FnMut(&mut F) -> O,
{
    #[inline]
    fn update(&mut self, _: Tick<'_, R>) {
        self.output = Some((self.law)(self.filter));
    }
}

#[diagnostic::do_not_recommend]
impl<R, F, L, I, O> SampledFilter<R> for Adapted<'_, F, L, Sample<I>, O>
where
    R: Rate,
    F: ?Sized,
    L: FnMut(&mut F, I) -> O,
{
    #[inline]
    fn update(&mut self, tick: Tick<'_, R>) {
        if let Some(input) = self.inbox.take(&tick) {
            self.output = Some((self.law)(self.filter, input));
        }
    }
}

impl<F: ?Sized, L, N, O> Deref for Adapted<'_, F, L, N, O> {
    type Target = F;

    #[inline]
    fn deref(&self) -> &F {
        self.filter
    }
}

impl<F: ?Sized, L, N, O> DerefMut for Adapted<'_, F, L, N, O> {
    #[inline]
    fn deref_mut(&mut self) -> &mut F {
        self.filter
    }
}

impl<F: fmt::Debug + ?Sized, L, N, O> fmt::Debug for Adapted<'_, F, L, N, O> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.filter.fmt(f)
    }
}

impl<F: fmt::Display + ?Sized, L, N, O> fmt::Display for Adapted<'_, F, L, N, O> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.filter.fmt(f)
    }
}
