//! Cycles that take too long, in the worlds where time passes.

use crate::{Each, InEveryWorld, Timer, counts, run};
use ceid_core::Time;
use ceid_core::prelude::*;
use ceid_core::thread::{Outcome, SuperloopCycleThread, Task, Until};
use core::time::Duration;
use std::cell::Cell;
use std::rc::Rc;
use std::sync::Mutex;
use std::time::Instant;

/// A cycle that takes a while.
fn spend(duration: Duration) {
    let begin = Instant::now();
    while begin.elapsed() < duration {
        std::hint::spin_loop();
    }
}

struct Conserved(Overrun);

impl InEveryWorld for Conserved {
    fn test<T: RealtimeThread>(&self, world: &str, thread: T) {
        let infos = Mutex::new(Vec::new());
        let slow_in_cycle_3 = |info: CycleInfo| {
            if info.n == 3 {
                spend(Duration::from_micros(12_500));
            }
            infos.lock().expect("no cycle panics").push(info);
            Flow::Continue
        };
        let mut task = Task::new("slow", Each::<200, _>(slow_in_cycle_3), self.0);
        run(thread, &mut [&mut task], Until::duration(Duration::from_millis(100)));
        let infos = infos.lock().expect("no cycle panics").clone();
        assert_eq!(task.cycles(), infos.len() as u64, "{world}");
        assert_eq!(task.cycles() + task.missed(), 20, "{world}: {infos:?}");
        assert_eq!(infos.iter().map(|info| info.missed).sum::<u64>(), task.missed(), "{world}: {infos:?}");
        assert_eq!(infos.last().map(|info| info.n), Some(19), "{world}: {infos:?}");
        assert!(infos.is_sorted_by(|one, next| one.n + 1 + next.missed == next.n), "{world}: {infos:?}");
        assert!(infos.iter().all(|info| info.release_ns == info.n * 5_000_000), "{world}: {infos:?}");
    }
}

#[test]
fn cycles_and_missed_releases_are_all_releases() {
    Conserved(Overrun::Skip).run();
    Conserved(Overrun::CatchUp { max: 1 }).run();
    Conserved(Overrun::CatchUp { max: u32::MAX }).run();
}

struct Stops;

impl InEveryWorld for Stops {
    fn test<T: RealtimeThread>(&self, world: &str, thread: T) {
        let slow_in_cycle_3 = |info: CycleInfo| {
            if info.n == 3 {
                spend(Duration::from_millis(230));
            }
            Flow::Continue
        };
        let mut slow = Task::new("slow", Each::<10, _>(slow_in_cycle_3), Overrun::Stop);
        let mut other = Task::new("other", Each::<10, _>(|_| Flow::Continue), Overrun::Skip);
        run(thread, &mut [&mut slow, &mut other], Until::duration(Duration::from_secs(1)));
        if world == "simulated" {
            assert_eq!(counts(&slow), (10, 0, Some(Outcome::Completed)), "a cycle takes no virtual time");
            return;
        }
        // Release 4 and those after it that had come when the cycle was over; on a busy machine, earlier ones.
        assert_eq!(slow.outcome(), Some(Outcome::Overran), "{world}");
        assert!(slow.cycles() <= 4 && slow.missed() >= 2, "{world}: {slow:?}");
        assert_eq!(other.outcome(), Some(Outcome::EndedByAnother), "{world}");
    }
}

#[test]
fn an_overrun_ends_the_run_if_that_was_asked_for() {
    Stops.run();
}

/// A clock that only the test moves.
#[derive(Clone)]
struct Manual(Rc<Cell<u64>>);

impl Time for Manual {
    fn now_ns(&mut self) -> u64 {
        self.0.get()
    }

    fn sleep_until_ns(&mut self, at_ns: u64) {
        self.0.set(at_ns);
    }
}

#[test]
fn a_task_of_a_superloop_is_late_by_the_cycles_of_the_others() {
    use std::sync::atomic::{AtomicU64, Ordering};
    static NOW_NS: AtomicU64 = AtomicU64::new(7);

    /// A clock that the cycles move.
    struct Moved;
    impl Time for Moved {
        fn now_ns(&mut self) -> u64 {
            NOW_NS.load(Ordering::Relaxed)
        }
        fn sleep_until_ns(&mut self, at_ns: u64) {
            NOW_NS.store(at_ns, Ordering::Relaxed);
        }
    }

    let slow = |_: CycleInfo| {
        NOW_NS.fetch_add(2_300_000, Ordering::Relaxed);
        Flow::Continue
    };
    let mut vision = Task::new("vision", Each::<100, _>(slow), Overrun::Skip);
    let mut motor =
        Task::new("motor", Each::<1000, _>(|_| Flow::Continue), Overrun::Skip).with_histogram::<30>(100_000);
    let mut thread = SuperloopCycleThread::new(Moved);
    thread.run(&mut [&mut vision, &mut motor], Until::duration(Duration::from_millis(100)));
    assert_eq!(counts(&vision), (10, 0, Some(Outcome::Completed)));
    // In each tenth of a second: releases 0 and 1 pass, release 2 begins 0.3 ms late, the other seven are on time.
    assert_eq!(counts(&motor), (80, 20, Some(Outcome::Completed)));
    let lateness = motor.lateness();
    assert_eq!((lateness.buckets()[0], lateness.buckets()[3], lateness.count()), (70, 10, 80));
    assert_eq!(lateness.max_ns(), 300_000);
}

#[test]
fn a_clock_that_is_not_send_will_do_for_a_superloop() {
    let mut task = Task::new("task", Each::<1000, _>(|_| Flow::Continue), Overrun::Stop);
    let manual = Manual(Rc::default());
    SuperloopCycleThread::new(manual.clone()).run(&mut [&mut task], Until::duration(Duration::from_secs(1)));
    assert_eq!((task.cycles(), manual.0.get()), (1000, 999_000_000));
}

#[test]
fn lateness_is_measured_where_time_passes() {
    let late = |info: CycleInfo| {
        spend(Duration::from_millis(if info.n == 0 { 3 } else { 0 }));
        Flow::Continue
    };
    let mut task = Task::new("task", Each::<500, _>(late), Overrun::CatchUp { max: 9 }).with_histogram::<10>(1_000_000);
    SuperloopCycleThread::new(Timer::new()).run(&mut [&mut task], Until::duration(Duration::from_millis(20)));
    assert!(task.lateness().max_ns() >= 1_000_000, "{:?}", task.lateness());
    assert_eq!(task.lateness().count(), task.cycles());
}
