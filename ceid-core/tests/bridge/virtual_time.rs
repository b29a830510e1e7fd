//! Virtual time: exact, ordered, and the same in every run.

use crate::{Each, counts};
use ceid_core::prelude::*;
use ceid_core::thread::{Outcome, SimulatedCycleThread, Task, Until};
use core::time::Duration;
use std::sync::Mutex;

/// What three tasks do in a run: who, which release, when.
fn trace(duration: Duration) -> Vec<(&'static str, CycleInfo)> {
    let log = Mutex::new(Vec::new());
    let write = |name| {
        let log = &log;
        move |info: CycleInfo| {
            log.lock().expect("no cycle panics").push((name, info));
            Flow::Continue
        }
    };
    let mut vision = Task::new("vision", Each::<30, _>(write("vision")), Overrun::Stop);
    let mut motor = Task::new("motor", Each::<100, _>(write("motor")), Overrun::Stop);
    let mut sensors = Task::new("sensors", Each::<1000, _>(write("sensors")), Overrun::Stop);
    SimulatedCycleThread::new().run(&mut [&mut vision, &mut motor, &mut sensors], Until::duration(duration));
    for task in [counts(&vision), counts(&motor), counts(&sensors)] {
        assert_eq!((task.1, task.2), (0, Some(Outcome::Completed)));
    }
    log.into_inner().expect("no cycle panics")
}

#[test]
fn every_release_before_the_end_has_its_cycle() {
    let trace = trace(Duration::from_secs(2));
    let count = |name| trace.iter().filter(|(task, _)| *task == name).count();
    assert_eq!([count("vision"), count("motor"), count("sensors")], [60, 200, 2000]);
}

#[test]
fn cycles_are_in_the_order_of_their_releases_and_then_of_the_tasks() {
    let trace = trace(Duration::from_secs(2));
    assert!(trace.is_sorted_by_key(|(_, info)| info.release_ns));
    let at_once: Vec<_> = trace.iter().filter(|(_, info)| info.release_ns == 1_000_000_000).map(|it| it.0).collect();
    assert_eq!(at_once, ["vision", "motor", "sensors"]);
    assert!(trace.iter().all(|(_, info)| (info.late_ns, info.missed) == (0, 0)));
}

#[test]
fn two_runs_are_alike() {
    assert_eq!(trace(Duration::from_millis(1234)), trace(Duration::from_millis(1234)));
}

#[test]
fn releases_that_are_due_at_once_are_compared_exactly() {
    // 1/3 s is no whole number of nanoseconds: release 1 at 3 Hz and release 2 at 6 Hz are the same moment, and so is
    // no other pair in between.
    let log = Mutex::new(String::new());
    let write = |letter| {
        let log = &log;
        move |_: CycleInfo| {
            log.lock().expect("no cycle panics").push(letter);
            Flow::Continue
        }
    };
    let mut six = Task::new("six", Each::<6, _>(write('6')), Overrun::Stop);
    let mut three = Task::new("three", Each::<3, _>(write('3')), Overrun::Stop);
    SimulatedCycleThread::new().run(&mut [&mut six, &mut three], Until::duration(Duration::from_secs(1)));
    assert_eq!(*log.lock().expect("no cycle panics"), "636636636");
}

#[test]
fn a_run_may_be_longer_than_any_life() {
    let mut task = Task::new("task", Each::<1, _>(|info: CycleInfo| stop_after(info, 1000)), Overrun::Stop);
    SimulatedCycleThread::new().run(&mut [&mut task], Until::duration(Duration::MAX));
    assert_eq!(counts(&task), (1001, 0, Some(Outcome::Finished)));
}

fn stop_after(info: CycleInfo, n: u64) -> Flow {
    if info.n < n { Flow::Continue } else { Flow::Stop }
}
