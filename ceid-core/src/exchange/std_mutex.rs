//! The lock of the standard library (feature `std`).

use std::sync::{Mutex, PoisonError};

use super::Lock;

/// `std::sync::Mutex`, for [`Locked`](super::Locked).
///
/// Blocks until the other end has copied its value, and as long as the scheduler keeps that end from running: there is
/// no bound, because a thread of middle priority can do so for ever (priority inversion). Does not allocate on Linux,
/// nor after the first use elsewhere. A mutex poisoned by a panic is used on: a value is replaced whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StdMutex {}

impl Lock for StdMutex {
    type Mutex<T: Copy + Send> = Mutex<T>;

    #[inline]
    fn mutex<T: Copy + Send>(value: T) -> Mutex<T> {
        Mutex::new(value)
    }

    #[inline]
    fn with<T: Copy + Send, R>(mutex: &Mutex<T>, body: impl FnOnce(&mut T) -> R) -> R {
        body(&mut mutex.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
