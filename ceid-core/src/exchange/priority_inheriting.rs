//! A mutex whose holder inherits the priority of whoever waits for it: the futex of Linux with `FUTEX_LOCK_PI` (feature
//! `linux-rt`).

use core::cell::{Cell, UnsafeCell};
use core::fmt;
use core::sync::atomic::{AtomicU32, Ordering};
use std::thread;

use super::Lock;

/// [`PriorityInheritingMutex`], for [`Locked`](super::Locked).
///
/// Blocks until the other end has copied its value. While it waits, the other end runs at least at this end's priority,
/// so no thread between the two can prolong the wait: the bound is the copy, two system calls, and what has a
/// still higher priority. Neither allocates nor panics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PriorityInheriting {}

impl Lock for PriorityInheriting {
    type Mutex<T: Copy + Send> = PriorityInheritingMutex<T>;

    #[inline]
    fn mutex<T: Copy + Send>(value: T) -> PriorityInheritingMutex<T> {
        PriorityInheritingMutex::new(value)
    }

    #[inline]
    fn with<T: Copy + Send, R>(mutex: &PriorityInheritingMutex<T>, body: impl FnOnce(&mut T) -> R) -> R {
        mutex.with(body)
    }
}

/// A mutex without priority inversion.
///
/// ```
/// use ceid_core::exchange::PriorityInheritingMutex;
///
/// static TOTAL: PriorityInheritingMutex<u32> = PriorityInheritingMutex::new(0);
/// assert_eq!(TOTAL.with(|total| { *total += 1; *total }), 1);
/// ```
///
/// Where the kernel lacks such futexes (an emulator), a waiting thread yields and tries again: mutual exclusion stays,
/// inheritance does not. A process that was forked while threads used the mutex must not use it.
pub struct PriorityInheritingMutex<T> {
    /// The thread id of the holder, 0 if there is none; the kernel adds a bit when others wait.
    futex: AtomicU32,
    value: UnsafeCell<T>,
}

// SAFETY: one thread at a time reaches the value, by `&mut`, hence `Send` is enough.
unsafe impl<T: Send> Sync for PriorityInheritingMutex<T> {}

impl<T> PriorityInheritingMutex<T> {
    /// A free mutex that holds `value`. Does not allocate, block or panic.
    #[must_use]
    #[inline]
    pub const fn new(value: T) -> Self {
        Self { futex: AtomicU32::new(0), value: UnsafeCell::new(value) }
    }

    /// Runs `body` on the value while no other thread can reach it.
    ///
    /// Blocks until the holder's `body` is done, during which the holder inherits this thread's priority; without a
    /// holder, one atomic exchange. To lock the same mutex again inside `body` deadlocks. Neither allocates nor panics;
    /// a panic of `body` frees the mutex and goes on.
    #[inline]
    pub fn with<R>(&self, body: impl FnOnce(&mut T) -> R) -> R {
        let _held = self.lock();
        // SAFETY: this thread holds the mutex until `_held` is dropped, after `body`.
        body(unsafe { &mut *self.value.get() })
    }

    #[inline]
    fn lock(&self) -> Held<'_> {
        let thread = thread_id();
        if self.futex.compare_exchange(0, thread, Ordering::Acquire, Ordering::Relaxed).is_err() {
            lock_contended(&self.futex, thread);
        }
        Held { futex: &self.futex, thread }
    }
}

impl<T> fmt::Debug for PriorityInheritingMutex<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PriorityInheritingMutex").finish_non_exhaustive()
    }
}

/// Frees the mutex when dropped, also by a panic.
struct Held<'m> {
    futex: &'m AtomicU32,
    thread: u32,
}

impl Drop for Held<'_> {
    #[inline]
    fn drop(&mut self) {
        if self.futex.compare_exchange(self.thread, 0, Ordering::Release, Ordering::Relaxed).is_err() {
            unlock_contended(self.futex);
        }
    }
}

/// Returns when this thread holds the mutex.
#[cold]
fn lock_contended(futex: &AtomicU32, thread: u32) {
    // The kernel takes the mutex for this thread. Where it refuses (interrupted, unsupported, out of memory), the loop
    // goes on without its help.
    while !futex_call(futex, libc::FUTEX_LOCK_PI) {
        if futex.compare_exchange(0, thread, Ordering::Acquire, Ordering::Relaxed).is_ok() {
            return;
        }
        thread::yield_now();
    }
    // The kernel wrote the word; this read orders what follows after what the last holder did.
    core::sync::atomic::fence(Ordering::Acquire);
}

/// Hands the mutex to the waiting thread of the highest priority.
#[cold]
fn unlock_contended(futex: &AtomicU32) {
    // The kernel writes the word without an ordering that the language knows of.
    core::sync::atomic::fence(Ordering::Release);
    while !futex_call(futex, libc::FUTEX_UNLOCK_PI) {
        thread::yield_now();
    }
}

fn futex_call(futex: &AtomicU32, operation: libc::c_int) -> bool {
    let private = operation | libc::FUTEX_PRIVATE_FLAG;
    let no_timeout = core::ptr::null::<libc::timespec>();
    // SAFETY: the word outlives the call, which keeps no pointer to it. The operations use no further argument.
    unsafe { libc::syscall(libc::SYS_futex, futex.as_ptr(), private, 0, no_timeout) == 0 }
}

/// The kernel's id of this thread, asked for once per thread.
#[inline]
fn thread_id() -> u32 {
    std::thread_local! {
        static ID: Cell<u32> = const { Cell::new(0) };
    }
    ID.with(|id| {
        if id.get() == 0 {
            // SAFETY: takes nothing, and always succeeds.
            id.set(unsafe { libc::syscall(libc::SYS_gettid) } as u32);
        }
        id.get()
    })
}
