//! A run of no length, a stop request, a functionality that stops, and one that panics.

use crate::{Each, InEveryWorld, counts, run};
use ceid_core::prelude::*;
use ceid_core::thread::{Outcome, StopSignal, Task, Until};
use core::time::Duration;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU64, Ordering};

/// There it is the scheduler's affair whether the other task had begun.
fn runs_in_a_thread(world: &str) -> bool {
    matches!(world, "chrono" | "rt-preempt")
}

struct ZeroLength;

impl InEveryWorld for ZeroLength {
    fn test<T: RealtimeThread>(&self, world: &str, thread: T) {
        let mut task = Task::new("never called", Each::<1000, _>(|_| panic!("{world}")), Overrun::Stop);
        assert_eq!(task.outcome(), None);
        run(thread, &mut [&mut task], Until::duration(Duration::ZERO));
        assert_eq!(counts(&task), (0, 0, Some(Outcome::Completed)), "{world}");
        assert_eq!(task.lateness().count(), 0, "{world}");
    }
}

#[test]
fn a_run_of_no_length_calls_nothing() {
    ZeroLength.run();
}

struct NoTasks;

impl InEveryWorld for NoTasks {
    fn test<T: RealtimeThread>(&self, _: &str, thread: T) {
        run(thread, &mut [], Until::finished());
    }
}

#[test]
fn a_run_of_no_tasks_ends() {
    NoTasks.run();
}

struct StopRequest;

impl InEveryWorld for StopRequest {
    fn test<T: RealtimeThread>(&self, world: &str, thread: T) {
        let stop = StopSignal::new();
        let stop_in_cycle_5 = |info: CycleInfo| {
            if info.n >= 5 {
                stop.raise();
            }
            Flow::Continue
        };
        let mut one = Task::new("one", Each::<1000, _>(stop_in_cycle_5), Overrun::CatchUp { max: u32::MAX });
        let mut other = Task::new("other", Each::<10, _>(|_| Flow::Continue), Overrun::Skip);
        run(thread, &mut [&mut one, &mut other], Until::duration(Duration::from_secs(3600)).or_stopped(&stop));
        assert_eq!(counts(&one), (6, 0, Some(Outcome::Stopped)), "{world}: the cycle is finished, no other begins");
        assert_eq!(other.outcome(), Some(Outcome::Stopped), "{world}");
        assert!(runs_in_a_thread(world) || other.cycles() == 1, "{world}");
    }
}

#[test]
fn a_stop_request_ends_every_task_before_its_next_cycle() {
    StopRequest.run();
}

struct StoppedBefore;

impl InEveryWorld for StoppedBefore {
    fn test<T: RealtimeThread>(&self, world: &str, thread: T) {
        let stop = StopSignal::new();
        stop.raise();
        let mut task = Task::new("never called", Each::<1000, _>(|_| panic!("{world}")), Overrun::Skip);
        run(thread, &mut [&mut task], Until::stopped(&stop));
        assert_eq!(counts(&task), (0, 0, Some(Outcome::Stopped)), "{world}");
    }
}

#[test]
fn a_request_before_the_run_lets_no_cycle_begin() {
    StoppedBefore.run();
}

struct Finished;

impl InEveryWorld for Finished {
    fn test<T: RealtimeThread>(&self, world: &str, mut thread: T) {
        let stop_at_3 = |info: CycleInfo| if info.n < 3 { Flow::Continue } else { Flow::Stop };
        let mut one =
            Task::new("one", Each::<1000, _>(stop_at_3), Overrun::CatchUp { max: u32::MAX }).with_histogram::<1>(1);
        let mut other = Task::new("other", Each::<20, _>(|_| Flow::Continue), Overrun::Skip);
        for _ in 0..2 {
            // The second run counts from release 0 again.
            let _report = thread.run(&mut [&mut one, &mut other], Until::finished());
            assert_eq!(counts(&one), (4, 0, Some(Outcome::Finished)), "{world}");
            assert_eq!(one.lateness().count(), 4, "{world}");
            assert_eq!(other.outcome(), Some(Outcome::EndedByAnother), "{world}");
            assert!(runs_in_a_thread(world) || other.cycles() == 1, "{world}");
        }
    }
}

#[test]
fn a_functionality_that_stops_ends_the_run() {
    Finished.run();
}

/// Counts its updates where the test sees them.
struct Counter<'c>(&'c AtomicU64);

impl<R: Rate> SampledFilter<R> for Counter<'_> {
    fn update(&mut self, _: Tick<'_, R>) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

struct Panics;

impl InEveryWorld for Panics {
    fn test<T: RealtimeThread>(&self, world: &str, mut thread: T) {
        let updates = AtomicU64::new(0);
        let mut control = Cyclic::new(Counter(&updates), Free::<Hz<1000>>::new());
        let panics_in_cycle_2 = |info: CycleInfo| {
            let _guard = control.cycle();
            if info.n == 2 {
                // Without the hook, which would print it.
                std::panic::resume_unwind(Box::new("sensor on fire"));
            }
            Flow::Continue
        };
        let mut one = Task::new("one", Each::<1000, _>(panics_in_cycle_2), Overrun::CatchUp { max: u32::MAX });
        let mut other = Task::new("other", Each::<20, _>(|_| Flow::Continue), Overrun::Skip);

        let run = AssertUnwindSafe(|| thread.run(&mut [&mut one, &mut other], Until::finished()));
        let payload = catch_unwind(run).map(|_| ()).expect_err("the panic goes on in the caller");
        assert_eq!(payload.downcast_ref(), Some(&"sensor on fire"), "{world}");
        assert_eq!(counts(&one), (3, 0, Some(Outcome::Panicked)), "{world}");
        assert_eq!(other.outcome(), Some(Outcome::EndedByAnother), "{world}");
        assert!(runs_in_a_thread(world) || other.cycles() == 1, "{world}");
        assert_eq!(updates.load(Ordering::Relaxed), 3, "{world}: the guard of the third cycle did its work");

        // Never called again, and without it nothing runs.
        let _report = thread.run(&mut [&mut one, &mut other], Until::finished());
        assert_eq!(counts(&one), (0, 0, Some(Outcome::Panicked)), "{world}");
        assert_eq!(counts(&other), (0, 0, Some(Outcome::EndedByAnother)), "{world}");
    }
}

#[test]
fn a_panic_ends_the_run_and_goes_on_in_its_caller() {
    Panics.run();
}
