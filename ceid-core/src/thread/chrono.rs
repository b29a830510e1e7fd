//! Ordinary threads of an operating system, with the clock of the standard library (feature `std`).

use std::vec::Vec;
use std::{fs, io};

use super::workers::{self, Workers};
use super::{CyclicTask, Granted, Privilege, Privileges, RealtimeThread, Until};
use crate::cycle::StdTime;

/// Runs each task in a thread of its own, as punctually as an ordinary thread can be.
///
/// Needs no privilege and runs wherever the standard library does. On Linux each thread asks for the shortest timer
/// slack, which every user may have, and which makes a wake-up some 50 µs more punctual; whether it was granted is in the
/// [`Privileges`].
#[doc(alias = "ChronoCycleLogicalThread")]
#[derive(Debug, Clone, Copy, Default)]
pub struct ChronoCycleThread(());

impl ChronoCycleThread {
    /// Ordinary threads. Does not allocate, block or panic.
    #[must_use]
    pub const fn new() -> Self {
        Self(())
    }
}

impl RealtimeThread for ChronoCycleThread {
    type Report = Privileges;

    /// Allocates and makes threads before release 0, not in the loop. Blocks for the whole run.
    fn run(&mut self, tasks: &mut [&mut dyn CyclicTask], until: Until<'_>) -> Privileges {
        workers::run(tasks, &Chrono { time: StdTime::new() }, until)
    }
}

struct Chrono {
    time: StdTime,
}

impl Workers for Chrono {
    type Time = StdTime;

    fn prepare(&self, task: &'static str, _: u32) -> Granted {
        Granted { task, timer_slack: Privilege::of(shorten_timer_slack()), ..Granted::default() }
    }

    fn may_begin(&self, _: &[Granted]) -> bool {
        true
    }

    fn time(&self) -> StdTime {
        self.time
    }
}

/// Asks the kernel not to delay the timers of this thread, through a file, so that no foreign function is needed.
fn shorten_timer_slack() -> io::Result<()> {
    let this_thread = fs::read_link("/proc/thread-self")?;
    let id = this_thread.file_name().ok_or(io::ErrorKind::NotFound)?;
    let file: std::path::PathBuf = ["/proc".as_ref(), id, "timerslack_ns".as_ref()].iter().collect();
    fs::write(&file, "1")?;
    // Read back: some sandboxes accept the write and ignore it.
    let set: Vec<u8> = fs::read(&file)?;
    if set.trim_ascii() == b"1" { Ok(()) } else { Err(io::ErrorKind::Unsupported.into()) }
}
