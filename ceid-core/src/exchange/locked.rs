//! Values behind a lock, whichever lock it is.

use core::fmt;
use core::marker::PhantomData;

use super::{Exchange, ExchangeCell, Read, Reading, Write};

/// The exchange that locks: its cell is [`LockedCell`]. `L` is the lock.
///
/// An end waits for the other end's critical section, which is one copy of the value, and for whatever the lock adds to
/// that: see its kind. Prefer [`Latest`](super::Latest) where it exists.
#[doc(alias = "Locker")]
pub struct Locked<L> {
    lock: PhantomData<fn() -> L>,
}

impl<L> fmt::Debug for Locked<L> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Locked").finish()
    }
}

impl<L: Lock> Exchange for Locked<L> {
    type Cell<T: Copy + Send> = LockedCell<T, L>;
}

/// A kind of lock that a [`LockedCell`] can use: a mutex for each type of value.
///
/// ```
/// use ceid_core::exchange::{ExchangeCell, Lock, LockedCell, Read, Write};
/// use std::sync::Mutex;
///
/// /// A lock of your own.
/// struct Spin;
///
/// impl Lock for Spin {
///     type Mutex<T: Copy + Send> = Mutex<T>;
///
///     fn mutex<T: Copy + Send>(value: T) -> Mutex<T> {
///         Mutex::new(value)
///     }
///
///     fn with<T: Copy + Send, R>(mutex: &Mutex<T>, body: impl FnOnce(&mut T) -> R) -> R {
///         loop {
///             match mutex.try_lock() {
///                 Ok(mut value) => break body(&mut value),
///                 Err(_) => core::hint::spin_loop(),
///             }
///         }
///     }
/// }
///
/// let mut cell = LockedCell::<u8, Spin>::new(0);
/// let (mut writer, mut reader) = cell.split();
/// writer.set(1);
/// assert!(reader.get().is_fresh());
/// ```
pub trait Lock: 'static {
    /// The mutex that holds a value.
    type Mutex<T: Copy + Send>: Send + Sync;

    /// A mutex that holds `value`. Does not allocate, block or panic.
    fn mutex<T: Copy + Send>(value: T) -> Self::Mutex<T>;

    /// Runs `body` on the value while nobody else can reach it.
    ///
    /// Blocks until the mutex is free; an implementation says what bounds that. It must neither allocate nor panic, and
    /// must free the mutex also when `body` panics.
    fn with<T: Copy + Send, R>(mutex: &Self::Mutex<T>, body: impl FnOnce(&mut T) -> R) -> R;
}

/// What a [`LockedCell`] keeps behind its lock.
#[derive(Debug, Clone, Copy)]
pub struct LockState<T> {
    value: T,
    fresh: bool,
    /// The ends of a shared cell were given out.
    taken: bool,
}

/// A cell that holds one value behind a lock of the kind `L`.
///
#[cfg_attr(feature = "std", doc = "```")]
#[cfg_attr(not(feature = "std"), doc = "```ignore")]
/// use ceid_core::exchange::{ExchangeCell, LockedCell, Read, Reading, StdMutex, Write};
///
/// let mut cell = LockedCell::<f32, StdMutex>::new(0.0);
/// let (mut writer, mut reader) = cell.split();
/// writer.set(0.7);
/// assert_eq!(reader.get(), Reading::Fresh(0.7));
/// assert_eq!(reader.get(), Reading::Stale(0.7));
/// ```
///
/// No method allocates or panics. Writing and reading block as the lock does, and hold it for one copy of the value.
pub struct LockedCell<T: Copy + Send, L: Lock> {
    state: L::Mutex<LockState<T>>,
}

impl<T: Copy + Send, L: Lock> ExchangeCell<T> for LockedCell<T, L> {
    type Writer<'c>
        = LockedWriter<'c, T, L>
    where
        Self: 'c;
    type Reader<'c>
        = LockedReader<'c, T, L>
    where
        Self: 'c;

    #[inline]
    fn new(initial: T) -> Self {
        Self { state: L::mutex(LockState { value: initial, fresh: false, taken: false }) }
    }

    #[inline]
    fn split(&mut self) -> (LockedWriter<'_, T, L>, LockedReader<'_, T, L>) {
        (LockedWriter { cell: self }, LockedReader { cell: self })
    }

    #[inline]
    fn split_once(&self) -> Option<(LockedWriter<'_, T, L>, LockedReader<'_, T, L>)> {
        let taken = L::with(&self.state, |state| core::mem::replace(&mut state.taken, true));
        (!taken).then_some((LockedWriter { cell: self }, LockedReader { cell: self }))
    }
}

impl<T: Copy + Send, L: Lock> fmt::Debug for LockedCell<T, L> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LockedCell").finish_non_exhaustive()
    }
}

/// The end of a [`LockedCell`] that writes.
pub struct LockedWriter<'c, T: Copy + Send, L: Lock> {
    cell: &'c LockedCell<T, L>,
}

impl<T: Copy + Send, L: Lock> Write<T> for LockedWriter<'_, T, L> {
    #[inline]
    fn set(&mut self, value: T) {
        L::with(&self.cell.state, |state| {
            state.value = value;
            state.fresh = true;
        });
    }
}

impl<T: Copy + Send, L: Lock> fmt::Debug for LockedWriter<'_, T, L> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LockedWriter").finish_non_exhaustive()
    }
}

/// The end of a [`LockedCell`] that reads.
pub struct LockedReader<'c, T: Copy + Send, L: Lock> {
    cell: &'c LockedCell<T, L>,
}

impl<T: Copy + Send, L: Lock> Read<T> for LockedReader<'_, T, L> {
    #[inline]
    fn get(&mut self) -> Reading<T> {
        L::with(&self.cell.state, |state| {
            let value = state.value;
            if core::mem::replace(&mut state.fresh, false) { Reading::Fresh(value) } else { Reading::Stale(value) }
        })
    }
}

impl<T: Copy + Send, L: Lock> fmt::Debug for LockedReader<'_, T, L> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LockedReader").finish_non_exhaustive()
    }
}
