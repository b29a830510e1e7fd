//! Every raw lock with the interface of the crate `lock_api` (feature `lock-api`): `parking_lot`, `spin` and others.

use core::marker::PhantomData;

use ::lock_api::{Mutex, RawMutex};

use super::Lock;

/// A `lock_api` mutex, for [`Locked`](super::Locked): `Locked<LockApi<parking_lot::RawMutex>>`.
///
/// Blocks as the raw lock `R` does; none of those in wide use inherits priorities, so there is no bound. Neither
/// allocates nor panics unless `R` does.
#[derive(Debug)]
pub struct LockApi<R> {
    raw: PhantomData<fn() -> R>,
}

impl<R: RawMutex + Send + Sync + 'static> Lock for LockApi<R> {
    type Mutex<T: Copy + Send> = Mutex<R, T>;

    #[inline]
    fn mutex<T: Copy + Send>(value: T) -> Mutex<R, T> {
        Mutex::new(value)
    }

    #[inline]
    fn with<T: Copy + Send, O>(mutex: &Mutex<R, T>, body: impl FnOnce(&mut T) -> O) -> O {
        body(&mut mutex.lock())
    }
}
