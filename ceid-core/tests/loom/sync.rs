//! loom's counterparts of `src/exchange/sync.rs`, and the bugs that can be seeded in them.

use std::cell::Cell;

pub(crate) use loom::sync::atomic::{AtomicBool, Ordering};

/// What is wrong with the atomic swap of the triple buffer.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Bug {
    None,
    /// `Relaxed`: orders nothing.
    Relaxed,
    /// Without `Release`: a value may be seen before it is written.
    AcquireOnly,
    /// Without `Acquire`: a slot may be written while it is still read.
    ReleaseOnly,
    /// Two steps in place of one.
    NotAtomic,
}

std::thread_local! {
    // loom runs all threads of a model in one thread of the system.
    static SEEDED: Cell<Bug> = const { Cell::new(Bug::None) };
}

pub(crate) fn seed(bug: Bug) {
    SEEDED.set(bug);
}

pub(crate) struct AtomicU8(loom::sync::atomic::AtomicU8);

impl AtomicU8 {
    pub(crate) fn new(value: u8) -> Self {
        Self(loom::sync::atomic::AtomicU8::new(value))
    }

    pub(crate) fn load(&self, ordering: Ordering) -> u8 {
        self.0.load(ordering)
    }

    pub(crate) fn swap(&self, value: u8, ordering: Ordering) -> u8 {
        match SEEDED.get() {
            Bug::None => self.0.swap(value, ordering),
            Bug::Relaxed => self.0.swap(value, Ordering::Relaxed),
            Bug::AcquireOnly => self.0.swap(value, Ordering::Acquire),
            Bug::ReleaseOnly => self.0.swap(value, Ordering::Release),
            Bug::NotAtomic => {
                // Not a plain load: loom 0.7 then overlooks other orders of the store that follows.
                let old = self.0.fetch_or(0, Ordering::AcqRel);
                self.0.store(value, Ordering::Release);
                old
            }
        }
    }
}

pub(crate) use loom::cell::UnsafeCell;

macro_rules! constructor {
    ($(#[$attribute:meta])* pub const fn $($rest:tt)*) => { $(#[$attribute])* pub fn $($rest)* };
}
pub(crate) use constructor;
