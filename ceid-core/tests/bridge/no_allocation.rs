//! No loop allocates, nor does an exchange.

use crate::{Each, InEveryWorld, run};
use ceid_core::TransactionIo;
use ceid_core::exchange::Latest;
use ceid_core::prelude::*;
use ceid_core::thread::{Task, Until};
use core::time::Duration;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// Counts the allocations of each thread.
struct Counting;

std::thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    ALLOCATIONS.set(ALLOCATIONS.get() + 1);
}

// SAFETY: passes every call on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: as the caller promises.
        unsafe { System.realloc(block, layout, size) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        count();
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(block, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

struct Test;

impl InEveryWorld for Test {
    fn test<T: RealtimeThread>(&self, world: &str, thread: T) {
        let (mut before, mut after) = (0, 0);
        let mut io = TransactionIo::<[f64; 8], [f64; 8], Latest>::new([0.0; 8], [0.0; 8]);
        let (mut outside, mut inside) = io.split();
        let cycle = |info: CycleInfo| {
            // From the end of the first cycle on, to the beginning of the last.
            after = ALLOCATIONS.get();
            outside.set_input([info.n as f64; 8]);
            let input = inside.input().value();
            inside.set_output(input);
            assert!(outside.output().is_fresh());
            if before == 0 {
                before = ALLOCATIONS.get().max(1);
            }
            Flow::Continue
        };
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        {
            let mut task = Task::new("task", Each::<1000, _>(cycle), Overrun::CatchUp { max: u32::MAX })
                .with_histogram::<1000>(1_000);
            run(thread, &mut [&mut task], Until::duration(Duration::from_millis(50)));
            assert_eq!(task.cycles(), 50, "{world}: {task:?}");
        }
        assert_eq!(after, before, "{world}: allocations in the loop");
    }
}

#[test]
fn no_loop_allocates() {
    Test.run();
}
