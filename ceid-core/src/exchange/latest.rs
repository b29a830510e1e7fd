//! The triple buffer: three slots, of which the writer owns one, the reader owns one, and the third lies between them.
//! To publish, the writer swaps its slot with the one between; to read, the reader does. Nobody waits.

use core::fmt;

use super::Reading;
use super::sync::{AtomicBool, AtomicU8, Ordering, UnsafeCell, constructor};

/// Set in the shared byte beside the index of the slot between: the slot was published and not read yet.
const FRESH: u8 = 0b100;
const INDEX: u8 = 0b011;

/// A wait-free cell: one writer, one reader, the latest value.
///
/// ```
/// use ceid_core::exchange::{LatestCell, Reading};
///
/// static SPEED: LatestCell<f32> = LatestCell::new(0.0);
///
/// let (mut writer, mut reader) = SPEED.split_once().expect("nobody has taken the ends yet");
/// assert_eq!(reader.read(), Reading::Stale(&0.0));
/// writer.set(0.5);
/// writer.set(0.7);
/// assert_eq!(reader.read(), Reading::Fresh(&0.7));
/// assert_eq!(reader.read(), Reading::Stale(&0.7));
/// ```
///
/// No method allocates, blocks or panics. Writing is one copy of the value and one atomic byte swap, reading is one
/// atomic load and, if the value is fresh, one swap: wait-free where a swap is one instruction (x86, ARMv8.1) or masks
/// interrupts (`portable-atomic`). On machines that build the swap of a load and a conditional store (ARMv7, RISC-V) the
/// hardware repeats it if the other end swaps in that very moment.
///
/// The value is stored three times; on hosted targets each slot has its own cache lines, so that the two ends do not
/// slow each other down.
#[doc(alias = "TripleBuffer")]
pub struct LatestCell<T> {
    slots: [Padded<UnsafeCell<T>>; 3],
    /// The index of the slot between, and `FRESH`.
    between: Padded<AtomicU8>,
    /// A copy of the index of the writer's slot, from which ends that are taken anew go on where the last ones stopped.
    back: Padded<UnsafeCell<u8>>,
    taken: AtomicBool,
}

/// Keeps its content off the cache lines of its neighbours, where there are caches.
#[cfg_attr(not(target_os = "none"), repr(align(128)))]
struct Padded<T>(T);

// SAFETY: only a cell has these. A shared cell gives out one writer and one reader at most (`split_once`), and their
// protocol never lets both touch one slot or one index at a time; a value travels from the writer's thread to the reader's,
// hence `Send`.
unsafe impl<T: Send> Sync for Padded<T> {}

impl<T: Copy> LatestCell<T> {
    constructor! {
        /// A cell that holds `initial`, which its reader will find stale.
        ///
        /// `const`, so the cell may be a `static`. Does not allocate, block or panic.
        #[must_use]
        #[inline]
        pub const fn new(initial: T) -> Self {
            Self {
                slots: [
                    Padded(UnsafeCell::new(initial)),
                    Padded(UnsafeCell::new(initial)),
                    Padded(UnsafeCell::new(initial)),
                ],
                back: Padded(UnsafeCell::new(0)),
                between: Padded(AtomicU8::new(1)),
                taken: AtomicBool::new(false),
            }
        }
    }
}

impl<T> LatestCell<T> {
    /// The two ends, for as long as the cell is borrowed.
    ///
    /// They can be had again when both are gone, and go on with the value that is there. Does not allocate, block or
    /// panic.
    #[inline]
    pub fn split(&mut self) -> (LatestWriter<'_, T>, LatestReader<'_, T>) {
        // SAFETY: the exclusive borrow shows that there are no ends now, and lasts as long as those that are made.
        unsafe { self.ends() }
    }

    /// The two ends of a shared cell: the first call has them, every later call gets `None`.
    ///
    /// Does not allocate, block or panic.
    #[must_use]
    #[inline]
    pub fn split_once(&self) -> Option<(LatestWriter<'_, T>, LatestReader<'_, T>)> {
        // No data is handed over here: whoever wins finds what the cell was made with.
        if self.taken.swap(true, Ordering::Relaxed) {
            return None;
        }
        // SAFETY: only one call gets here, and `split` cannot be called while the borrow of its ends lasts.
        Some(unsafe { self.ends() })
    }

    /// Makes the two ends.
    ///
    /// # Safety
    ///
    /// There are no other ends while these live.
    #[inline]
    unsafe fn ends(&self) -> (LatestWriter<'_, T>, LatestReader<'_, T>) {
        // SAFETY: only the writer touches `back`, and there is none yet.
        let back = self.back.0.with(|back| unsafe { *back });
        // Relaxed: the last ends are gone, and whatever told this thread so has ordered what they did.
        let between = self.between.0.load(Ordering::Relaxed) & INDEX;
        // The three indices are 0, 1 and 2 in some order, and 0 ^ 1 ^ 2 is 3.
        let front = 3 ^ back ^ between;
        // SAFETY: the indices are 0, 1 and 2 from the start, and are only ever swapped.
        let slot = unsafe { self.slot(front) };
        (LatestWriter { cell: self, back }, LatestReader { cell: self, front, slot })
    }

    /// The slot of an index.
    ///
    /// # Safety
    ///
    /// `index` is below 3.
    #[inline]
    unsafe fn slot(&self, index: u8) -> &Padded<UnsafeCell<T>> {
        debug_assert!(index < 3, "an index of the protocol is out of range");
        // SAFETY: the caller vouches for the index. A checked access would be the only panic of the cell.
        unsafe { self.slots.get_unchecked(usize::from(index)) }
    }

    /// Gives a slot away, and takes the one between for it.
    #[inline]
    fn exchange(&self, given: u8) -> u8 {
        // Release: what was done to the given slot (a write; or reads, which the next write must not overtake) comes
        // before the swap. Acquire: what is done to the taken slot comes after what its last owner did.
        self.between.0.swap(given, Ordering::AcqRel) & INDEX
    }
}

impl<T> fmt::Debug for LatestCell<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LatestCell").finish_non_exhaustive()
    }
}

/// The end of a [`LatestCell`] that writes.
pub struct LatestWriter<'c, T> {
    cell: &'c LatestCell<T>,
    /// The index of the writer's slot.
    back: u8,
}

impl<T: Copy> LatestWriter<'_, T> {
    /// Publishes a value; the reader will find it fresh, and will never see the value before it.
    ///
    /// Wait-free: one copy of the value and one atomic swap. Does not allocate, block or panic.
    #[inline]
    pub fn set(&mut self, value: T) {
        // SAFETY: the indices are 0, 1 and 2 from the start, and are only ever swapped. The slot is the writer's: the
        // reader takes a slot only after it was given away below.
        unsafe { self.cell.slot(self.back).0.with_mut(|slot| *slot = value) };
        self.back = self.cell.exchange(self.back | FRESH);
        // SAFETY: only the writer touches `back`, there is one writer, and it is borrowed exclusively here.
        self.cell.back.0.with_mut(|back| unsafe { *back = self.back });
    }
}

impl<T> fmt::Debug for LatestWriter<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LatestWriter").finish_non_exhaustive()
    }
}

/// The end of a [`LatestCell`] that reads.
pub struct LatestReader<'c, T> {
    cell: &'c LatestCell<T>,
    /// The index of the reader's slot.
    front: u8,
    /// That slot, found when it was taken, because it is read more often.
    slot: &'c Padded<UnsafeCell<T>>,
}

impl<T> LatestReader<'_, T> {
    /// The latest value, in place, and whether it was written since the last read.
    ///
    /// The value does not change while the reference lives, whatever the writer does. Wait-free: one atomic load, and
    /// one swap if the value is fresh. Does not allocate, block or panic.
    #[inline]
    pub fn read(&mut self) -> Reading<&T> {
        // Relaxed: this only asks whether to swap; the swap orders the accesses.
        let is_fresh = self.cell.between.0.load(Ordering::Relaxed) & FRESH != 0;
        if is_fresh {
            self.take();
        }
        // SAFETY: the slot is the reader's until its next swap, which needs the exclusive borrow that the reference holds.
        let value = self.slot.0.with(|slot| unsafe { &*slot });
        if is_fresh { Reading::Fresh(value) } else { Reading::Stale(value) }
    }
}

impl<T> LatestReader<'_, T> {
    /// Takes the slot between, which is fresh. Cold, because a swap takes long in any case, while the other way is so
    /// short that one jump more counts.
    #[cold]
    #[inline]
    fn take(&mut self) {
        self.front = self.cell.exchange(self.front);
        // SAFETY: the index is in range as in `set`.
        self.slot = unsafe { self.cell.slot(self.front) };
    }
}

impl<T> fmt::Debug for LatestReader<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LatestReader").finish_non_exhaustive()
    }
}
