//! What the operating system granted to a run, and what it refused.

use core::fmt;
use std::io::ErrorKind;
use std::vec::Vec;

/// One thing that a run may ask of the operating system.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Privilege {
    /// The run did not ask for it.
    #[default]
    NotAsked,
    /// The run has it.
    Granted,
    /// The run does not have it, for this reason.
    Refused(ErrorKind),
}

impl Privilege {
    pub(super) fn of(result: std::io::Result<()>) -> Self {
        result.map_or_else(|error| Self::Refused(error.kind()), |()| Self::Granted)
    }
}

/// What the thread of one task was granted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Granted {
    /// The name of the task.
    pub task: &'static str,
    /// Waking up without the 50 µs by which Linux may delay the timers of ordinary threads.
    pub timer_slack: Privilege,
    /// The scheduling policy and priority asked for, as read back from the kernel.
    pub scheduling: Privilege,
    /// Running on one processor only, as read back from the kernel.
    pub processor: Privilege,
    /// The priority that the kernel reports; 0 if the policy has none.
    pub priority: i32,
}

/// What a run was granted and refused: returned by every run that asks for anything.
///
/// Printed with `{}`, it is one line for each refusal, which says what to do.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[must_use = "a privilege that was refused changes how late cycles may be: look at `is_refused`, or print it"]
pub struct Privileges {
    /// No page of the process can be swapped out (`mlockall`).
    pub memory_lock: Privilege,
    /// Processors do not go into deep sleep (`/dev/cpu_dma_latency`).
    pub shallow_sleep: Privilege,
    /// A thread for each task; if one is refused, the run does not begin.
    pub threads_made: Privilege,
    /// Per task, in the order of the tasks; shorter if threads were refused.
    pub threads: Vec<Granted>,
}

impl Privileges {
    /// Whether anything that was asked for was refused. Does not allocate, block or panic; takes time for each thread.
    #[must_use]
    pub fn is_refused(&self) -> bool {
        self.refused().next().is_some()
    }

    /// What was refused: the task, if it is about one, what it is, and why. Does not allocate, block or panic; takes time for
    /// each thread.
    pub fn refused(&self) -> impl Iterator<Item = (Option<&'static str>, &'static str, ErrorKind)> + '_ {
        let process = [
            (None, MEMORY_LOCK, self.memory_lock),
            (None, SHALLOW_SLEEP, self.shallow_sleep),
            (None, THREADS, self.threads_made),
        ];
        let threads = self.threads.iter().flat_map(|granted| {
            let task = Some(granted.task);
            [
                (task, TIMER_SLACK, granted.timer_slack),
                (task, SCHEDULING, granted.scheduling),
                (task, PROCESSOR, granted.processor),
            ]
        });
        process.into_iter().chain(threads).filter_map(|(task, what, privilege)| match privilege {
            Privilege::Refused(kind) => Some((task, what, kind)),
            Privilege::NotAsked | Privilege::Granted => None,
        })
    }
}

const MEMORY_LOCK: &str = "locked memory";
const SHALLOW_SLEEP: &str = "shallow sleep of the processors";
const THREADS: &str = "a thread for each task";
const TIMER_SLACK: &str = "short timer slack";
const SCHEDULING: &str = "real-time scheduling";
const PROCESSOR: &str = "a processor of its own choice";

/// What a user can do about a refusal.
fn advice(what: &str) -> &'static str {
    match what {
        MEMORY_LOCK => "raise the limit `memlock` or grant CAP_IPC_LOCK",
        SHALLOW_SLEEP => "let this user write /dev/cpu_dma_latency",
        THREADS => "raise the limits `nproc`, and `memlock` if memory is locked",
        TIMER_SLACK => "needs Linux with a writable /proc; cycles begin up to 50 µs later",
        SCHEDULING => "raise the limit `rtprio` or grant CAP_SYS_NICE, and check the priority or runtime",
        _ => "choose a processor that is online and allowed to this process",
    }
}

impl fmt::Display for Privileges {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (at, (task, what, kind)) in self.refused().enumerate() {
            let separator = if at == 0 { "" } else { "\n" };
            let task = task.unwrap_or("process");
            write!(f, "{separator}{task}: refused {what}: {kind} ({})", advice(what))?;
        }
        Ok(())
    }
}
