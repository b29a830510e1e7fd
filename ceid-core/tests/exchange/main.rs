//! Exchanges: fresh and stale, one pair of ends, nothing torn or reordered. Each test runs with every exchange.

#[cfg(all(feature = "linux-rt", target_os = "linux"))]
mod inversion;
mod stress;

use ceid_core::TransactionIo;
use ceid_core::exchange::{Exchange, ExchangeCell, Latest, LatestCell, Read, Reading, Write};

/// Runs a test with every exchange, by name.
pub(crate) trait WithEveryExchange {
    fn test<X: Exchange + 'static>(&self, exchange: &str);

    fn run(&self) {
        self.test::<Latest>("Latest");
        #[cfg(feature = "std")]
        self.test::<ceid_core::exchange::Locked<ceid_core::exchange::StdMutex>>("StdMutex");
        #[cfg(all(feature = "linux-rt", target_os = "linux"))]
        self.test::<ceid_core::exchange::Locked<ceid_core::exchange::PriorityInheriting>>("PriorityInheriting");
        #[cfg(feature = "lock-api")]
        self.test::<ceid_core::exchange::Locked<ceid_core::exchange::LockApi<spin::Raw>>>("LockApi");
        #[cfg(feature = "critical-section")]
        self.test::<ceid_core::exchange::Locked<ceid_core::exchange::CriticalSection>>("CriticalSection");
    }
}

/// A raw lock as other crates have it.
#[cfg(feature = "lock-api")]
mod spin {
    use std::sync::atomic::{AtomicBool, Ordering};

    pub(crate) struct Raw(AtomicBool);

    // SAFETY: `lock` returns only to the thread whose exchange found the lock free.
    unsafe impl lock_api::RawMutex for Raw {
        const INIT: Self = Self(AtomicBool::new(false));
        type GuardMarker = lock_api::GuardSend;

        fn lock(&self) {
            while !self.try_lock() {
                std::thread::yield_now();
            }
        }

        fn try_lock(&self) -> bool {
            !self.0.swap(true, Ordering::Acquire)
        }

        unsafe fn unlock(&self) {
            self.0.store(false, Ordering::Release);
        }
    }
}

struct FreshAndStale;

impl WithEveryExchange for FreshAndStale {
    fn test<X: Exchange + 'static>(&self, exchange: &str) {
        let mut cell = X::Cell::<u32>::new(7);
        let (mut writer, mut reader) = cell.split();
        assert_eq!(reader.get(), Reading::Stale(7), "{exchange}: nobody has written it");
        writer.set(1);
        assert_eq!(reader.get(), Reading::Fresh(1), "{exchange}");
        assert_eq!(reader.get(), Reading::Stale(1), "{exchange}");
        assert_eq!(reader.get(), Reading::Stale(1), "{exchange}");
        (2..10).for_each(|value| writer.set(value));
        assert_eq!(reader.get(), Reading::Fresh(9), "{exchange}: only the latest");
        writer.set(9);
        assert_eq!(reader.get(), Reading::Fresh(9), "{exchange}: equal, and yet new");
    }
}

#[test]
fn a_reader_knows_fresh_from_stale() {
    FreshAndStale.run();
}

struct SplitAgain;

impl WithEveryExchange for SplitAgain {
    fn test<X: Exchange + 'static>(&self, exchange: &str) {
        // Every number of writes and reads before, so that each slot of a triple buffer has its turn.
        for (writes, reads) in (0..5).flat_map(|writes| (0..5).map(move |reads| (writes, reads))) {
            let mut cell = X::Cell::<u32>::new(0);
            let mut expected = Reading::Stale(0);
            for round in 0..3 {
                let (mut writer, mut reader) = cell.split();
                assert_eq!(reader.get(), expected, "{exchange}: {writes} writes, {reads} reads, round {round}");
                for write in 0..writes {
                    writer.set(round * 10 + write + 1);
                    (0..reads).for_each(|_| assert_eq!(reader.get().value(), round * 10 + write + 1));
                }
                let last = if writes > 0 { round * 10 + writes } else { 0 };
                expected = if writes > 0 && reads == 0 { Reading::Fresh(last) } else { Reading::Stale(last) };
            }
        }
    }
}

#[test]
fn new_ends_go_on_where_the_last_ones_stopped() {
    SplitAgain.run();
}

struct Once;

impl WithEveryExchange for Once {
    fn test<X: Exchange + 'static>(&self, exchange: &str) {
        let mut cell = X::Cell::<u32>::new(0);
        {
            let (mut writer, mut reader) = cell.split_once().expect("the first call has the ends");
            assert!(cell.split_once().is_none(), "{exchange}");
            writer.set(1);
            assert_eq!(reader.get(), Reading::Fresh(1), "{exchange}");
        }
        assert!(cell.split_once().is_none(), "{exchange}: also when the ends are gone");
        let (mut writer, mut reader) = cell.split();
        assert_eq!(reader.get(), Reading::Stale(1), "{exchange}");
        writer.set(2);
        assert_eq!(reader.get(), Reading::Fresh(2), "{exchange}");
    }
}

#[test]
fn a_shared_cell_gives_out_its_ends_once() {
    Once.run();
}

struct BothDirections;

impl WithEveryExchange for BothDirections {
    fn test<X: Exchange + 'static>(&self, exchange: &str) {
        let mut io = TransactionIo::<u32, &str, X>::new(0, "off");
        {
            let (mut outside, mut inside) = io.split();
            assert_eq!((inside.input(), outside.output()), (Reading::Stale(0), Reading::Stale("off")), "{exchange}");
            outside.set_input(1);
            inside.set_output("on");
            assert_eq!((inside.input(), outside.output()), (Reading::Fresh(1), Reading::Fresh("on")), "{exchange}");
            outside.set_input(2);
        }
        let (mut outside, mut inside) = io.split();
        assert_eq!((inside.input(), outside.output()), (Reading::Fresh(2), Reading::Stale("on")), "{exchange}");
    }
}

#[test]
fn a_transaction_hands_over_in_both_directions() {
    BothDirections.run();
}

#[test]
fn a_value_that_is_being_read_does_not_change() {
    let mut cell = LatestCell::new([0; 4]);
    let (mut writer, mut reader) = cell.split();
    writer.set([1; 4]);
    let value = reader.read().value();
    (2..9).for_each(|n| writer.set([n; 4]));
    assert_eq!(value, &[1; 4]);
    assert_eq!(reader.read(), Reading::Fresh(&[8; 4]));
}

#[test]
fn a_value_that_is_being_read_does_not_change_after_any_history() {
    // Two steps with ends of their own, each some writes and reads, and then the same question.
    for steps in (0..256_u32).map(|steps| [steps % 4, steps / 4 % 4, steps / 16 % 4, steps / 64]) {
        let mut cell = LatestCell::new([0; 4]);
        let mut n = 0;
        for step in steps.chunks(2) {
            let (mut writer, mut reader) = cell.split();
            for _ in 0..step[0] {
                n += 1;
                writer.set([n; 4]);
            }
            (0..step[1]).for_each(|_| assert_eq!(reader.read().value(), &[n; 4], "{steps:?}"));
        }
        let (mut writer, mut reader) = cell.split();
        let value = reader.read().value();
        (100..105).for_each(|later| writer.set([later; 4]));
        assert_eq!(value, &[n; 4], "{steps:?}");
        assert_eq!(reader.read(), Reading::Fresh(&[104; 4]), "{steps:?}");
    }
}

#[test]
fn a_static_transaction_needs_no_run_time_initialisation() {
    static IO: TransactionIo<u8, u8, Latest> = TransactionIo::from_cells(LatestCell::new(1), LatestCell::new(2));
    let (mut outside, mut inside) = IO.split_once().expect("nobody else has the ends");
    assert_eq!((inside.input().value(), outside.output().value()), (1, 2));
    assert!(IO.split_once().is_none());
}

#[test]
fn readings_can_be_changed_and_keep_their_freshness() {
    assert_eq!(Reading::Fresh(2).map(|value| value * 2), Reading::Fresh(4));
    assert_eq!(Reading::Stale(2).map(|value| value * 2), Reading::Stale(4));
    assert_eq!((Reading::Fresh(2).fresh(), Reading::Stale(2).fresh()), (Some(2), None));
    assert!(Reading::Fresh(()).is_fresh() && !Reading::Stale(()).is_fresh());
}

#[cfg(feature = "std")]
#[test]
fn a_mutex_poisoned_by_a_panic_is_used_on() {
    use ceid_core::exchange::{Lock, StdMutex};
    let mutex = StdMutex::mutex(1);
    let panics = std::panic::AssertUnwindSafe(|| StdMutex::with(&mutex, |_| std::panic::resume_unwind(Box::new(()))));
    assert!(std::panic::catch_unwind(panics).is_err());
    assert_eq!(StdMutex::with(&mutex, |value| *value), 1);
}

#[cfg(all(feature = "linux-rt", target_os = "linux"))]
#[test]
fn a_panic_frees_a_priority_inheriting_mutex() {
    let mutex = ceid_core::exchange::PriorityInheritingMutex::new(1);
    let panics = std::panic::AssertUnwindSafe(|| mutex.with(|_| std::panic::resume_unwind(Box::new(()))));
    assert!(std::panic::catch_unwind(panics).is_err());
    assert_eq!(std::thread::scope(|scope| scope.spawn(|| mutex.with(|value| *value)).join()).ok(), Some(1));
}

#[cfg(all(feature = "linux-rt", target_os = "linux"))]
#[test]
fn a_priority_inheriting_mutex_excludes() {
    let total = ceid_core::exchange::PriorityInheritingMutex::new(0_u64);
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                for _ in 0..20_000 {
                    total.with(|total| *total += 1);
                }
            });
        }
    });
    assert_eq!(total.with(|total| *total), 80_000);
}
