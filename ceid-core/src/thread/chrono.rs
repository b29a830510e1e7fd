//! Ordinary threads of an operating system, with the clock of the standard library (feature `std`).

use core::hint::spin_loop;
use std::vec::Vec;
use std::{fs, io};

use super::workers::{self, Workers};
use super::{CyclicTask, Granted, Privilege, Privileges, RealtimeThread, Until};
use crate::cycle::{StdTime, Time};

/// Runs each task in a thread of its own, as punctually as an ordinary thread can be.
///
/// Needs no privilege and runs wherever the standard library does. On Linux each thread asks for the shortest timer
/// slack, which every user may have, and which makes a wake-up some 50 µs more punctual; whether it was granted is in the
/// [`Privileges`]. Each thread also learns by how much its wake-ups are late, asks to be woken that much earlier, at
/// most 50 µs, and awaits the rest awake: at 1 kHz, that costs at most a twentieth of a processor, and mostly far less.
/// No cycle begins before its release.
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

/// A clock that wakes up early by what wake-ups are usually late.
struct Punctual<T> {
    time: T,
    /// Half of the wake-ups are later than this, as far as it is learned.
    usually_late_ns: u64,
}

impl<T> Punctual<T> {
    /// The longest time that is awaited awake.
    const MOST_AWAKE_NS: u64 = 50_000;
    /// What one wake-up teaches.
    const STEP_NS: u64 = 1_000;
}

impl<T: Time> Time for Punctual<T> {
    fn now_ns(&mut self) -> u64 {
        self.time.now_ns()
    }

    fn sleep_until_ns(&mut self, at_ns: u64) {
        let wake_ns = at_ns.saturating_sub(self.usually_late_ns);
        if self.now_ns() < wake_ns {
            self.time.sleep_until_ns(wake_ns);
            // Up and down by the same step for more and for less is a median.
            self.usually_late_ns = if self.now_ns() > at_ns {
                (self.usually_late_ns + Self::STEP_NS).min(Self::MOST_AWAKE_NS)
            } else {
                self.usually_late_ns.saturating_sub(Self::STEP_NS)
            };
        }
        while self.now_ns() < at_ns {
            spin_loop();
        }
    }
}

impl Workers for Chrono {
    type Time = Punctual<StdTime>;

    fn prepare(&self, task: &'static str, _: u32) -> Granted {
        Granted { task, timer_slack: Privilege::of(shorten_timer_slack()), ..Granted::default() }
    }

    fn may_begin(&self, _: &[Granted]) -> bool {
        true
    }

    fn time(&self) -> Punctual<StdTime> {
        Punctual { time: self.time, usually_late_ns: 0 }
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

#[cfg(test)]
mod tests {
    use super::{Punctual, Time};

    /// A machine whose wake-ups are late by the same time, and where looking at the clock takes 100 ns.
    struct Late {
        now_ns: u64,
        by_ns: u64,
    }

    impl Time for Late {
        fn now_ns(&mut self) -> u64 {
            self.now_ns += 100;
            self.now_ns
        }

        fn sleep_until_ns(&mut self, at_ns: u64) {
            self.now_ns = self.now_ns.max(at_ns + self.by_ns);
        }
    }

    /// How late the last of many cycles of 1 ms begins, and how long before its release the thread was woken.
    fn last_of_many(by_ns: u64) -> (u64, u64) {
        let mut time = Punctual { time: Late { now_ns: 0, by_ns }, usually_late_ns: 0 };
        let mut late_ns = 0;
        for cycle in 1..=200 {
            let release_ns = cycle * 1_000_000;
            time.sleep_until_ns(release_ns);
            assert!(time.time.now_ns >= release_ns, "no cycle begins before its release");
            late_ns = time.time.now_ns - release_ns;
        }
        (late_ns, time.usually_late_ns)
    }

    #[test]
    fn wakes_up_early_by_what_it_is_usually_late() {
        for by_ns in [0, 5_500, 30_000] {
            let (late_ns, early_ns) = last_of_many(by_ns);
            assert!(late_ns <= 1_200, "{by_ns}: {late_ns}");
            assert!(early_ns.abs_diff(by_ns) <= 2_000, "{by_ns}: {early_ns}");
        }
    }

    #[test]
    fn awaits_no_more_than_its_share_awake() {
        let (late_ns, early_ns) = last_of_many(400_000);
        assert_eq!(early_ns, 50_000);
        assert!(late_ns <= 350_300, "{late_ns}");
    }
}
