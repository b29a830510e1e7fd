//! What an ordinary thread is granted.

use crate::Each;
use ceid_core::prelude::*;
use ceid_core::thread::{ChronoCycleThread, Privilege, Task, Until};
use core::time::Duration;
use std::path::Path;
use std::sync::Mutex;

/// The timer slack of this thread, as the kernel shows it, and whether it could be set.
fn timer_slack() -> Option<(bool, bool)> {
    let this_thread = std::fs::read_link("/proc/thread-self").ok()?;
    let file = Path::new("/proc").join(this_thread.file_name()?).join("timerslack_ns");
    let is_exact = || Some(std::fs::read_to_string(&file).ok()?.trim() == "1");
    let was_exact = is_exact()?;
    let can_be_set = std::fs::write(&file, "1").is_ok() && is_exact()?;
    Some((was_exact, can_be_set))
}

#[test]
fn an_ordinary_thread_says_whether_its_timers_are_exact() {
    let seen = Mutex::new(None);
    let look = |_: CycleInfo| {
        *seen.lock().expect("no cycle panics") = timer_slack();
        Flow::Continue
    };
    let mut task = Task::new("task", Each::<1000, _>(look), Overrun::Skip);
    let privileges = ChronoCycleThread::new().run(&mut [&mut task], Until::duration(Duration::from_nanos(1)));
    let (was_exact, can_be_set) = seen.lock().expect("no cycle panics").unwrap_or_default();
    assert_eq!(was_exact, can_be_set);
    assert_eq!(was_exact, privileges.threads[0].timer_slack == Privilege::Granted, "{privileges:?}");
    assert_eq!(privileges.is_refused(), !was_exact);
}
