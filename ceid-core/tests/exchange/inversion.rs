//! Priority inversion: a thread of high priority waits for a lock that a thread of low priority holds, while one in
//! between uses the processor. The benchmark of the bridge runs it too. Needs real-time priorities; says so where it has none.

use ceid_core::exchange::Lock;
#[cfg(test)]
use ceid_core::exchange::{PriorityInheriting, StdMutex};
use ceid_core::prelude::*;
use ceid_core::thread::{IfRefused, Outcome, RtPreemptCycleThread, Scheduling, Task, Until};
use std::io::Write as _;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

const HELD: Duration = Duration::from_millis(5);
const BUSY: Duration = Duration::from_millis(100);

fn work(duration: Duration) {
    // Processor time, of which a thread that is preempted gets none.
    let mut worked = Duration::ZERO;
    let mut last = Instant::now();
    while worked < duration {
        let now = Instant::now();
        worked += (now - last).min(Duration::from_micros(50));
        last = now;
    }
}

/// The three threads, told apart by their rates: the faster, the higher its priority. Each has one cycle of work.
struct Low<'m, L: Lock>(&'m L::Mutex<u8>);

impl<L: Lock> RealtimeFunctionality for Low<'_, L> {
    type Rate = Hz<1>;

    fn cycle(&mut self, _: CycleInfo) -> Flow {
        L::with(self.0, |_| work(HELD));
        Flow::Continue
    }
}

struct Middle;

impl RealtimeFunctionality for Middle {
    type Rate = Hz<500>;

    fn cycle(&mut self, info: CycleInfo) -> Flow {
        if info.n == 1 {
            work(BUSY);
        }
        Flow::Continue
    }
}

struct High<'m, L: Lock>(&'m L::Mutex<u8>, &'m AtomicU64);

impl<L: Lock> RealtimeFunctionality for High<'_, L> {
    type Rate = Hz<1000>;

    fn cycle(&mut self, info: CycleInfo) -> Flow {
        // Release 2 is at the moment when the middle one begins its work.
        if info.n == 0 {
            return Flow::Continue;
        }
        let begin = Instant::now();
        L::with(self.0, |_| ());
        self.1.fetch_max(begin.elapsed().as_nanos() as u64, Ordering::Relaxed);
        Flow::Continue
    }
}

/// How long the thread of the highest priority has waited; `None` without privileges.
pub(crate) fn longest_wait<L: Lock>() -> Option<Duration> {
    let mutex = L::mutex(0);
    let waited_ns = AtomicU64::new(0);
    let mut low = Task::new("low", Low::<L>(&mutex), Overrun::Skip);
    let mut middle = Task::new("middle", Middle, Overrun::Skip);
    let mut high = Task::new("high", High::<L>(&mutex, &waited_ns), Overrun::Skip);
    let scheduling = Scheduling::Fifo { priority: 30 };
    let mut thread = RtPreemptCycleThread::new(scheduling, IfRefused::DoNotRun).on_processor(0);
    let until = Until::duration(Duration::from_millis(150));
    let privileges = thread.run(&mut [&mut low, &mut middle, &mut high], until);
    if privileges.is_refused() {
        // Not by `println!`, which the test runner would hide.
        writeln!(std::io::stderr(), "SKIPPED the test of priority inversion:\n{privileges}").expect("stderr is open");
        return None;
    }
    assert_eq!(low.outcome(), Some(Outcome::Completed));
    Some(Duration::from_nanos(waited_ns.into_inner()))
}

#[test]
fn a_priority_inheriting_lock_is_waited_for_no_longer_than_it_is_held() {
    let Some(inherited) = longest_wait::<PriorityInheriting>() else { return };
    let Some(inverted) = longest_wait::<StdMutex>() else { return };
    assert!(inherited * 10 <= inverted, "{inherited:?} with inheritance, {inverted:?} with std's mutex");
}
