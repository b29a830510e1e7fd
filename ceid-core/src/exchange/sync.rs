//! What the triple buffer is made of. The models in `tests/loom` compile `latest.rs` against loom's counterparts of
//! these names, so that the code that ships is the code that is checked.

#[cfg(not(feature = "portable-atomic"))]
pub(super) use core::sync::atomic::{AtomicBool, AtomicU8, Ordering};
#[cfg(feature = "portable-atomic")]
pub(super) use portable_atomic::{AtomicBool, AtomicU8, Ordering};

/// `core`'s cell with the interface of loom's.
pub(super) struct UnsafeCell<T>(core::cell::UnsafeCell<T>);

impl<T> UnsafeCell<T> {
    #[inline]
    pub(super) const fn new(value: T) -> Self {
        Self(core::cell::UnsafeCell::new(value))
    }

    #[inline]
    pub(super) fn with<R>(&self, body: impl FnOnce(*const T) -> R) -> R {
        body(self.0.get())
    }

    #[inline]
    pub(super) fn with_mut<R>(&self, body: impl FnOnce(*mut T) -> R) -> R {
        body(self.0.get())
    }
}

/// A constructor that is `const`; loom's is not.
macro_rules! constructor {
    ($($constructor:tt)*) => { $($constructor)* };
}
pub(super) use constructor;
