//! Critical sections of the crate `critical-section` (feature `critical-section`): masked interrupts on bare metal.

use core::cell::Cell;

use ::critical_section::Mutex;

use super::Lock;

/// A critical section, for [`Locked`](super::Locked). The program chooses its implementation, as the crate
/// `critical-section` says.
///
/// On a single core it masks interrupts for two copies of the value, and never waits: that time is the bound, and what it
/// adds to the latency of interrupts. Neither allocates nor panics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CriticalSection {}

impl Lock for CriticalSection {
    type Mutex<T: Copy + Send> = Mutex<Cell<T>>;

    #[inline]
    fn mutex<T: Copy + Send>(value: T) -> Mutex<Cell<T>> {
        Mutex::new(Cell::new(value))
    }

    #[inline]
    fn with<T: Copy + Send, R>(mutex: &Mutex<Cell<T>>, body: impl FnOnce(&mut T) -> R) -> R {
        ::critical_section::with(|section| {
            let cell = mutex.borrow(section);
            let mut value = cell.get();
            let result = body(&mut value);
            cell.set(value);
            result
        })
    }
}
