//! What a real-time thread is granted and refused. Where the tests have no privileges, they say so and check the refusal.

use crate::{Each, counts};
use ceid_core::prelude::*;
use ceid_core::thread::{IfRefused, Outcome, Privilege, Privileges, RtPreemptCycleThread, Scheduling, Task, Until};
use core::time::Duration;
use std::io::Write as _;
use std::sync::Mutex;

const FIFO: Scheduling = Scheduling::Fifo { priority: 80 };

/// Not by `println!`, which the test runner would hide.
fn say_skipped(privileges: &Privileges) {
    writeln!(std::io::stderr(), "SKIPPED a test of real-time threads, at least in part:\n{privileges}")
        .expect("stderr is open");
}

#[test]
fn a_run_of_no_length_tells_what_would_be_granted() {
    let mut task = Task::new("task", Each::<1000, _>(|_| Flow::Stop), Overrun::Skip);
    let mut thread = RtPreemptCycleThread::new(FIFO, IfRefused::RunAnyway);
    let privileges = thread.run(&mut [&mut task], Until::duration(Duration::ZERO));
    assert_eq!(counts(&task), (0, 0, Some(Outcome::Completed)));
    assert_eq!(privileges.threads.len(), 1);
    assert_eq!(privileges.threads[0].task, "task");
    match privileges.threads[0].scheduling {
        Privilege::Granted => assert_eq!(privileges.threads[0].priority, 80),
        Privilege::Refused(kind) => assert!(privileges.to_string().contains(&kind.to_string()), "{privileges}"),
        Privilege::NotAsked => panic!("{privileges:?}"),
    }
    if privileges.is_refused() {
        say_skipped(&privileges);
    }
}

/// What can be refused on every machine.
fn refused(task: &mut Task<impl RealtimeFunctionality>, if_refused: IfRefused) -> Privileges {
    let mut thread = RtPreemptCycleThread::new(Scheduling::Fifo { priority: 0 }, if_refused).on_processor(1 << 20);
    thread.run(&mut [task], Until::duration(Duration::from_millis(10)))
}

#[test]
fn a_refusal_is_reported_with_what_to_do() {
    let mut task = Task::new("motor", Each::<1000, _>(|_| Flow::Continue), Overrun::CatchUp { max: 99 });
    let privileges = refused(&mut task, IfRefused::RunAnyway);
    assert!(privileges.is_refused());
    let what: Vec<_> = privileges.refused().filter_map(|(task, what, _)| task.map(|_| what)).collect();
    assert_eq!(what, ["real-time scheduling", "a processor of its own choice"]);
    let text = privileges.to_string();
    assert!(text.contains("motor: refused real-time scheduling: "), "{text}");
    assert!(text.contains("(raise the limit `rtprio` or grant CAP_SYS_NICE"), "{text}");
    assert_eq!(counts(&task), (10, 0, Some(Outcome::Completed)), "it runs all the same, as was asked for");
}

#[test]
fn no_cycle_runs_without_the_privileges_if_that_was_asked_for() {
    let mut task = Task::new("never called", Each::<1000, _>(|_| panic!("called")), Overrun::Skip);
    assert!(refused(&mut task, IfRefused::DoNotRun).is_refused());
    assert_eq!(counts(&task), (0, 0, Some(Outcome::NotStarted)));
}

/// The policy and priority of this thread, as the kernel shows them to everybody.
fn kernels_view() -> (i64, i64) {
    let stat = std::fs::read_to_string("/proc/thread-self/stat").expect("Linux has /proc");
    let fields: Vec<_> = stat.rsplit(')').next().expect("there is a last part").split_whitespace().collect();
    // Fields 41 and 40 of proc(5); the first one here is the third.
    (fields[38].parse().expect("a number"), fields[37].parse().expect("a number"))
}

#[test]
fn faster_tasks_have_higher_priorities() {
    let seen = Mutex::new(Vec::new());
    let look = |name| {
        let seen = &seen;
        move |_: CycleInfo| {
            seen.lock().expect("no cycle panics").push((name, kernels_view()));
            Flow::Continue
        }
    };
    let mut vision = Task::new("vision", Each::<30, _>(look("vision")), Overrun::Skip);
    let mut motor = Task::new("motor", Each::<100, _>(look("motor")), Overrun::Skip);
    let mut brake = Task::new("brake", Each::<100, _>(look("brake")), Overrun::Skip);
    let mut thread = RtPreemptCycleThread::new(FIFO, IfRefused::DoNotRun).on_processor(0);
    let until = Until::duration(Duration::from_nanos(1));
    let privileges = thread.run(&mut [&mut vision, &mut motor, &mut brake], until);
    if privileges.is_refused() {
        say_skipped(&privileges);
        assert_eq!(vision.outcome(), Some(Outcome::NotStarted));
        return;
    }
    let mut seen = seen.into_inner().expect("no cycle panics");
    seen.sort_unstable();
    assert_eq!(seen, [("brake", (1, 80)), ("motor", (1, 80)), ("vision", (1, 79))]);
    assert_eq!(privileges.threads.iter().map(|it| it.priority).collect::<Vec<_>>(), [79, 80, 80]);
}

#[test]
fn a_deadline_thread_runs() {
    let policy = Mutex::new(0);
    let look = |_: CycleInfo| {
        *policy.lock().expect("no cycle panics") = kernels_view().0;
        Flow::Continue
    };
    let mut task = Task::new("task", Each::<100, _>(look), Overrun::CatchUp { max: 99 });
    let runtime = Duration::from_millis(2);
    let mut thread = RtPreemptCycleThread::new(Scheduling::Deadline { runtime }, IfRefused::RunAnyway);
    let privileges = thread.run(&mut [&mut task], Until::duration(Duration::from_millis(50)));
    assert_eq!(counts(&task), (5, 0, Some(Outcome::Completed)));
    let is_deadline = *policy.lock().expect("no cycle panics") == 6;
    assert_eq!(is_deadline, privileges.threads[0].scheduling == Privilege::Granted);
    if !is_deadline {
        say_skipped(&privileges);
    }
}
