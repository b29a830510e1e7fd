//! A system that makes no further thread.

use crate::Each;
use ceid_core::prelude::*;
use ceid_core::thread::{ChronoCycleThread, CyclicTask, Outcome, Privilege, Task, Until};
use std::process::Command;

#[test]
fn a_thread_that_cannot_be_made_is_reported() {
    let this = std::env::current_exe().expect("a program knows its own path");
    let script = "ulimit -v 400000 && exec \"$0\" --exact refused_threads::with_little_memory --ignored --nocapture";
    // Large stacks and one heap: what is left when no further stack fits is enough for the threads that were made.
    let output = Command::new("sh")
        .args(["-c", script])
        .arg(this)
        .envs([("RUST_MIN_STACK", "67108864"), ("MALLOC_ARENA_MAX", "1")])
        .output()
        .expect("a shell can be started");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && text.contains("1 passed"), "{text}{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
#[ignore = "needs a process with little memory: the test above starts one"]
fn with_little_memory() {
    let task = || Task::new("never called", Each::<1000, _>(|_| panic!("called")), Overrun::Skip);
    // Their stacks alone are 64 MiB each.
    let mut tasks: Vec<_> = (0..30).map(|_| task()).collect();
    let mut every: Vec<_> = tasks.iter_mut().map(|task| task as &mut dyn CyclicTask).collect();
    let privileges = ChronoCycleThread::new().run(&mut every, Until::finished());
    assert!(matches!(privileges.threads_made, Privilege::Refused(_)), "{privileges:?}");
    assert!(privileges.is_refused());
    assert!(privileges.to_string().contains("refused a thread for each task"), "{privileges}");
    assert!(privileges.threads.len() < 30);
    assert!(tasks.iter().all(|task| task.outcome() == Some(Outcome::NotStarted) && task.released() == 0));
}
