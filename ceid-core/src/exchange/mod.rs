//! Exchanges: how one thread hands a value to another that runs at its own rate. Nothing here knows a cycle.
//!
//! A control loop wants the *latest* value, not a queue of old ones, and it must not wait for whoever writes it. So a
//! cell of an exchange holds one value, has one writer and one reader, and the reader is told whether the value is
//! fresh (written since the last read) or stale.
//!
//! | exchange | waits | on |
//! | --- | --- | --- |
//! | [`Latest`] | never | every target with atomic byte swaps |
//! | `Locked<StdMutex>` | for the other end's copy, and for whoever preempts it | `std` |
//! | `Locked<PriorityInheriting>` | for the other end's copy | Linux, feature `linux-rt` |
//! | `Locked<CriticalSection>` | for the other end's copy, with interrupts masked | feature `critical-section` |
//! | `Locked<LockApi<R>>` | as the raw lock `R` does | feature `lock-api` |
//!
//! Use [`Latest`] unless the target has no atomic swap (ARMv6-M, AVR) or memory is dear: it holds its value three
//! times. Values are `Copy`, so that the time for which a lock is held is that of copying them, and known.

#[cfg(feature = "critical-section")]
#[forbid(unsafe_code)]
mod critical_section;
#[cfg(any(target_has_atomic = "8", feature = "portable-atomic"))]
#[expect(unsafe_code, reason = "the slots are shared by a protocol that the borrow checker cannot see")]
mod latest;
#[cfg(feature = "lock-api")]
#[forbid(unsafe_code)]
mod lock_api;
#[forbid(unsafe_code)]
mod locked;
#[cfg(all(feature = "linux-rt", target_os = "linux"))]
#[expect(unsafe_code, reason = "a lock that hands out `&mut`, and the system call `futex`")]
mod priority_inheriting;
#[cfg(feature = "std")]
#[forbid(unsafe_code)]
mod std_mutex;
#[cfg(any(target_has_atomic = "8", feature = "portable-atomic"))]
#[forbid(unsafe_code)]
mod sync;

#[cfg(feature = "critical-section")]
pub use self::critical_section::CriticalSection;
#[cfg(any(target_has_atomic = "8", feature = "portable-atomic"))]
pub use self::latest::{LatestCell, LatestReader, LatestWriter};
#[cfg(feature = "lock-api")]
pub use self::lock_api::LockApi;
pub use self::locked::{Lock, LockState, Locked, LockedCell, LockedReader, LockedWriter};
#[cfg(all(feature = "linux-rt", target_os = "linux"))]
pub use self::priority_inheriting::{PriorityInheriting, PriorityInheritingMutex};
#[cfg(feature = "std")]
pub use self::std_mutex::StdMutex;

/// A value as its reader finds it: written since the last read, or seen before.
///
/// A value that nobody has written yet, the initial one, is stale.
///
/// ```
/// use ceid_core::exchange::Reading;
///
/// let reading = Reading::Stale(0.5);
/// assert_eq!(reading.value(), 0.5);
/// assert_eq!(reading.fresh(), None);
/// ```
///
/// No method of this type allocates, blocks or panics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[must_use]
pub enum Reading<T> {
    /// Written since the last read.
    Fresh(T),
    /// Read before, or never written.
    Stale(T),
}

impl<T> Reading<T> {
    /// The value, however old it is. Does not allocate, block or panic.
    #[must_use]
    #[inline]
    pub fn value(self) -> T {
        match self {
            Self::Fresh(value) | Self::Stale(value) => value,
        }
    }

    /// The value if it is fresh: what a filter may take as a new measurement. Does not allocate, block or panic.
    #[must_use]
    #[inline]
    pub fn fresh(self) -> Option<T> {
        match self {
            Self::Fresh(value) => Some(value),
            Self::Stale(_) => None,
        }
    }

    /// Whether the value was written since the last read. Does not allocate, block or panic.
    #[must_use]
    #[inline]
    pub const fn is_fresh(&self) -> bool {
        matches!(self, Self::Fresh(_))
    }

    /// The same freshness with another value. Does not allocate, block or panic unless `change` does.
    #[inline]
    pub fn map<U>(self, change: impl FnOnce(T) -> U) -> Reading<U> {
        match self {
            Self::Fresh(value) => Reading::Fresh(change(value)),
            Self::Stale(value) => Reading::Stale(change(value)),
        }
    }
}

/// A kind of exchange: [`Latest`], [`Locked`], or one of your own. It chooses the cell in which a value is handed over.
///
/// [`TransactionIo`](crate::TransactionIo) takes it as its parameter, where the paper has `Locker` and `Lock`.
#[doc(alias = "Locker")]
pub trait Exchange {
    /// The cell for values of type `T`.
    type Cell<T: Copy + Send>: ExchangeCell<T>;
}

/// A cell that holds one value, with one writer and one reader at a time.
pub trait ExchangeCell<T>: Sync {
    /// The end that writes; may go to another thread.
    type Writer<'c>: Write<T> + Send
    where
        Self: 'c;
    /// The end that reads; may go to another thread.
    type Reader<'c>: Read<T> + Send
    where
        Self: 'c;

    /// A cell that holds `initial`, which its reader will find stale. Does not allocate, block or panic.
    #[must_use]
    fn new(initial: T) -> Self
    where
        Self: Sized;

    /// The two ends. They can be had again when both are gone, and then go on with the value that is there.
    ///
    /// Does not allocate, block or panic.
    fn split(&mut self) -> (Self::Writer<'_>, Self::Reader<'_>);

    /// The two ends of a shared cell, such as a `static`: the first call has them, every later call gets `None`.
    ///
    /// Does not allocate or panic; blocks as a read of the cell does.
    fn split_once(&self) -> Option<(Self::Writer<'_>, Self::Reader<'_>)>;
}

/// The writing end of a cell.
pub trait Write<T> {
    /// Replaces the value; the reader will find it fresh.
    ///
    /// Whether it blocks, and for how long, is said by the exchange; it neither allocates nor panics.
    fn set(&mut self, value: T);
}

/// The reading end of a cell.
pub trait Read<T> {
    /// A copy of the latest value, and whether it is fresh.
    ///
    /// Whether it blocks, and for how long, is said by the exchange; it neither allocates nor panics.
    fn get(&mut self) -> Reading<T>;
}

/// The wait-free exchange: neither end ever waits for the other. Its cell is [`LatestCell`], a triple buffer.
#[cfg(any(target_has_atomic = "8", feature = "portable-atomic"))]
#[doc(alias = "triple buffer")]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Latest {}

#[cfg(any(target_has_atomic = "8", feature = "portable-atomic"))]
impl Exchange for Latest {
    type Cell<T: Copy + Send> = LatestCell<T>;
}

#[cfg(any(target_has_atomic = "8", feature = "portable-atomic"))]
impl<T: Copy + Send> ExchangeCell<T> for LatestCell<T> {
    type Writer<'c>
        = LatestWriter<'c, T>
    where
        Self: 'c;
    type Reader<'c>
        = LatestReader<'c, T>
    where
        Self: 'c;

    #[inline]
    fn new(initial: T) -> Self {
        Self::new(initial)
    }

    #[inline]
    fn split(&mut self) -> (LatestWriter<'_, T>, LatestReader<'_, T>) {
        self.split()
    }

    #[inline]
    fn split_once(&self) -> Option<(LatestWriter<'_, T>, LatestReader<'_, T>)> {
        self.split_once()
    }
}

#[cfg(any(target_has_atomic = "8", feature = "portable-atomic"))]
impl<T: Copy> Write<T> for LatestWriter<'_, T> {
    #[inline]
    fn set(&mut self, value: T) {
        self.set(value);
    }
}

#[cfg(any(target_has_atomic = "8", feature = "portable-atomic"))]
impl<T: Copy> Read<T> for LatestReader<'_, T> {
    #[inline]
    fn get(&mut self) -> Reading<T> {
        self.read().map(|value| *value)
    }
}
