//! The input and output of one functionality, with an end for each side. Nothing here knows how the values are handed
//! over.

use core::fmt;

use crate::exchange::{Exchange, ExchangeCell, Read, Reading, Write};

/// The input and the output of one functionality, each behind an exchange `X` of latest values.
///
/// The paper's class (Figure A1) shows both sides to whoever inherits it, and its own example calls `setInput` from the
/// inside. Here [`split`](TransactionIo::split) gives each side an end of its own, which has that side's two methods
/// only:
///
/// | | writes | reads |
/// | --- | --- | --- |
/// | [`Outside`]: the rest of the robot | [`set_input`](Outside::set_input) | [`output`](Outside::output) |
/// | [`Inside`]: the functionality | [`set_output`](Inside::set_output) | [`input`](Inside::input) |
///
/// ```
/// use ceid_core::TransactionIo;
/// use ceid_core::exchange::{Latest, Reading};
///
/// let mut io = TransactionIo::<f64, f64, Latest>::new(0.0, 0.0);
/// let (mut outside, mut inside) = io.split();
///
/// std::thread::scope(|scope| {
///     scope.spawn(move || {
///         let speed = inside.input().value();
///         inside.set_output(speed * 2.0);
///     });
///     outside.set_input(0.7);
/// });
/// assert!(outside.output().is_fresh());
/// ```
///
/// `X` is [`Latest`](crate::exchange::Latest), whose ends never wait, or [`Locked`](crate::exchange::Locked) over a lock.
/// To change it is to change this one type. Input and output are independent: no lock is held over both.
#[doc(alias = "TransactionIO")]
#[doc(alias = "TransactionIOIF")]
pub struct TransactionIo<I: Copy + Send, O: Copy + Send, X: Exchange> {
    input: X::Cell<I>,
    output: X::Cell<O>,
}

/// The two ends of a [`TransactionIo`], as [`split`](TransactionIo::split) gives them.
pub type Ends<'t, I, O, X> = (Outside<'t, I, O, X>, Inside<'t, I, O, X>);

impl<I: Copy + Send, O: Copy + Send, X: Exchange> TransactionIo<I, O, X> {
    /// Joins an input and an output that hold these values, which their readers will find stale.
    ///
    /// Does not allocate, block or panic.
    #[must_use]
    #[inline]
    pub fn new(input: I, output: O) -> Self {
        Self::from_cells(X::Cell::new(input), X::Cell::new(output))
    }

    /// Joins two cells; for a `static`, whose initialiser has to be `const`.
    ///
    /// ```
    /// use ceid_core::TransactionIo;
    /// use ceid_core::exchange::{Latest, LatestCell};
    ///
    /// static MOTOR: TransactionIo<f32, f32, Latest> = TransactionIo::from_cells(LatestCell::new(0.0), LatestCell::new(0.0));
    ///
    /// let (outside, inside) = MOTOR.split_once().expect("the ends are taken once, at start-up");
    /// assert!(MOTOR.split_once().is_none());
    /// ```
    ///
    /// Does not allocate, block or panic.
    #[must_use]
    #[inline]
    pub const fn from_cells(input: X::Cell<I>, output: X::Cell<O>) -> Self {
        Self { input, output }
    }

    /// The two ends, for as long as this is borrowed.
    ///
    /// They can be had again when both are gone, and go on with the values that are there. Does not allocate, block or
    /// panic.
    #[inline]
    pub fn split(&mut self) -> Ends<'_, I, O, X> {
        let (input_writer, input_reader) = self.input.split();
        let (output_writer, output_reader) = self.output.split();
        (Outside { input: input_writer, output: output_reader }, Inside { input: input_reader, output: output_writer })
    }

    /// The two ends of a shared one, such as a `static`: the first call has them, every later call gets `None`.
    ///
    /// Does not allocate or panic; blocks as a read of `X` does.
    #[must_use]
    #[inline]
    pub fn split_once(&self) -> Option<Ends<'_, I, O, X>> {
        let (input_writer, input_reader) = self.input.split_once()?;
        let (output_writer, output_reader) = self.output.split_once()?;
        Some((
            Outside { input: input_writer, output: output_reader },
            Inside { input: input_reader, output: output_writer },
        ))
    }
}

impl<I: Copy + Send, O: Copy + Send, X: Exchange> fmt::Debug for TransactionIo<I, O, X> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TransactionIo").finish_non_exhaustive()
    }
}

/// The end of a [`TransactionIo`] that the rest of the robot holds: sets the input, reads the output.
///
/// `Send`: it may go to another thread.
pub struct Outside<'t, I: Copy + Send, O: Copy + Send, X: Exchange>
where
    X::Cell<I>: 't,
    X::Cell<O>: 't,
{
    input: <X::Cell<I> as ExchangeCell<I>>::Writer<'t>,
    output: <X::Cell<O> as ExchangeCell<O>>::Reader<'t>,
}

impl<I: Copy + Send, O: Copy + Send, X: Exchange> Outside<'_, I, O, X> {
    /// Replaces the input; the functionality will find it fresh.
    ///
    /// Blocks as a write of `X` does: never with [`Latest`](crate::exchange::Latest). Does not allocate or panic.
    #[doc(alias = "setInput")]
    #[inline]
    pub fn set_input(&mut self, input: I) {
        self.input.set(input);
    }

    /// A copy of the latest output, fresh if it was set since the last call.
    ///
    /// Blocks as a read of `X` does: never with [`Latest`](crate::exchange::Latest). Does not allocate or panic.
    #[doc(alias = "getOutput")]
    #[inline]
    pub fn output(&mut self) -> Reading<O> {
        self.output.get()
    }
}

impl<I: Copy + Send, O: Copy + Send, X: Exchange> fmt::Debug for Outside<'_, I, O, X> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Outside").finish_non_exhaustive()
    }
}

/// The end of a [`TransactionIo`] that the functionality holds: reads the input, sets the output.
///
/// `Send`: it may go to another thread.
pub struct Inside<'t, I: Copy + Send, O: Copy + Send, X: Exchange>
where
    X::Cell<I>: 't,
    X::Cell<O>: 't,
{
    input: <X::Cell<I> as ExchangeCell<I>>::Reader<'t>,
    output: <X::Cell<O> as ExchangeCell<O>>::Writer<'t>,
}

impl<I: Copy + Send, O: Copy + Send, X: Exchange> Inside<'_, I, O, X> {
    /// A copy of the latest input, fresh if it was set since the last call.
    ///
    /// Blocks as a read of `X` does: never with [`Latest`](crate::exchange::Latest). Does not allocate or panic.
    #[doc(alias = "getInput")]
    #[inline]
    pub fn input(&mut self) -> Reading<I> {
        self.input.get()
    }

    /// Replaces the output; the outside will find it fresh.
    ///
    /// Blocks as a write of `X` does: never with [`Latest`](crate::exchange::Latest). Does not allocate or panic.
    #[doc(alias = "setOutput")]
    #[inline]
    pub fn set_output(&mut self, output: O) {
        self.output.set(output);
    }
}

impl<I: Copy + Send, O: Copy + Send, X: Exchange> fmt::Debug for Inside<'_, I, O, X> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Inside").finish_non_exhaustive()
    }
}
