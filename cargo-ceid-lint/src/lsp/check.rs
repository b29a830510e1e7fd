//! The thread that checks. It has one job at a time, and drops it when something newer is wanted; a panic costs the job only.

use std::any::Any;
use std::collections::BTreeMap;
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};

use super::Event;
use super::settings::Settings;
use super::unit::Loaded;
use crate::parallel::stay_with_large_stack;
use crate::pipeline::Report;
use crate::project::Project;
use crate::source::{DiskSource, MemorySource, ReadError, ReadSource};

/// A part of the code that is loaded and checked together.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Scope {
    /// A folder that the client has open.
    Folder(PathBuf),
    /// The open files that no folder's check reads.
    Elsewhere,
}

/// What may be another than at the last check; the later ones hold those before them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Extent {
    /// Texts that were open then, and are now.
    #[default]
    Texts,
    /// Files on the disk.
    Disk,
    /// The packages and their targets.
    Project,
}

/// What one check is to do.
#[derive(Clone, Debug)]
pub(super) struct Task {
    pub(super) scope: Scope,
    /// The files of [`Scope::Elsewhere`].
    pub(super) files: Vec<PathBuf>,
    /// What may be another than last time.
    pub(super) extent: Extent,
    /// A file for whose loops guards are offered.
    pub(super) offered: Option<PathBuf>,
    pub(super) settings: Settings,
}

/// Checks that are made on the same state of all texts.
#[derive(Clone, Debug)]
pub(super) struct Job {
    /// The number of that state.
    pub(super) state: u64,
    pub(super) tasks: Vec<Task>,
    /// The texts that are open.
    pub(super) buffers: Vec<(PathBuf, Arc<str>)>,
}

/// What came of a job.
#[derive(Debug)]
pub(super) struct Checked {
    pub(super) finished: Vec<(Scope, Outcome)>,
    /// What was dropped because a newer state is wanted.
    pub(super) dropped: Vec<Task>,
}

/// What came of a check.
#[derive(Debug)]
pub(super) enum Outcome {
    /// The code was checked, or what is wrong with the configuration was found.
    Checked(Box<Judged>),
    /// There is no code here.
    Nothing,
    /// The packages could not be loaded.
    NotLoaded {
        /// What happened, and what to do next.
        message: String,
    },
    /// A bug of the tool.
    Panicked {
        /// What the panic said.
        message: String,
    },
}

impl Outcome {
    fn is_panic(&self) -> bool {
        matches!(self, Self::Panicked { .. })
    }
}

/// A project with what was found in it.
#[derive(Debug)]
pub(super) struct Judged {
    pub(super) project: Arc<Project>,
    /// By parts that have nothing to do with each other: those in which nothing has changed are those of the check before.
    pub(super) reports: Vec<Arc<Report>>,
    /// What the user should know about how the project was loaded, if it was loaded now.
    pub(super) notices: Vec<String>,
}

/// How a check is made: tests make it in their own way.
pub(super) type Check = fn(&Task, &mut Option<Loaded>, &dyn Fn() -> Box<dyn ReadSource>) -> Outcome;

/// The checking thread, from outside.
#[derive(Debug)]
pub(super) struct Checker {
    jobs: Sender<Job>,
    wanted: Arc<AtomicU64>,
}

impl Checker {
    /// Starts the thread; what it finds goes to `events`.
    pub(super) fn start(events: Sender<Event>, check: Check) -> Self {
        let (jobs, inbox) = mpsc::channel();
        let wanted = Arc::new(AtomicU64::new(0));
        let seen = Arc::clone(&wanted);
        stay_with_large_stack(move || work(&inbox, &events, &seen, check));
        Self { jobs, wanted }
    }

    /// Says that the texts have changed: what is under way is of no use any more.
    pub(super) fn want_newer(&self) {
        self.wanted.fetch_add(1, Ordering::Relaxed);
    }

    /// The number of the state that is wanted.
    pub(super) fn wanted(&self) -> u64 {
        self.wanted.load(Ordering::Relaxed)
    }

    /// Hands over a job. There is one at a time.
    pub(super) fn give(&self, job: Job) {
        // The thread ends only with this sender.
        let _ = self.jobs.send(job);
    }
}

fn work(jobs: &Receiver<Job>, events: &Sender<Event>, wanted: &Arc<AtomicU64>, check: Check) {
    let mut loaded: BTreeMap<Scope, Option<Loaded>> = BTreeMap::new();
    for Job { state, tasks, buffers } in jobs {
        let disk = WantedDisk { state, wanted: Arc::clone(wanted), has_refused: Arc::default() };
        let mut done = Checked { finished: Vec::new(), dropped: Vec::new() };
        for task in tasks {
            let outcome = disk.is_wanted().then(|| {
                let cache = loaded.entry(task.scope.clone()).or_default();
                let outcome = caught(|| check(&task, cache, &|| overlay(&disk, &buffers)));
                let is_half_done = disk.has_refused.swap(false, Ordering::Relaxed);
                if let Some(loaded) = cache.as_mut().filter(|_| is_half_done || outcome.is_panic()) {
                    loaded.forget();
                }
                outcome
            });
            // A check that ran into a refusal has not seen all files.
            match outcome.filter(|_| disk.is_wanted()) {
                Some(outcome) => done.finished.push((task.scope, outcome)),
                None => done.dropped.push(task),
            }
        }
        if events.send(Event::Checked(done)).is_err() {
            return;
        }
    }
}

fn caught(check: impl FnOnce() -> Outcome) -> Outcome {
    panic::catch_unwind(AssertUnwindSafe(check))
        .unwrap_or_else(|payload| Outcome::Panicked { message: panic_message(payload.as_ref()) })
}

/// What a panic said.
pub(super) fn panic_message(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().copied().or_else(|| payload.downcast_ref::<String>().map(String::as_str));
    text.unwrap_or("no message").to_owned()
}

fn overlay(disk: &WantedDisk, buffers: &[(PathBuf, Arc<str>)]) -> Box<dyn ReadSource> {
    let mut source = MemorySource::over(Box::new(disk.clone()));
    for (path, text) in buffers {
        source.insert(path, Arc::clone(text));
    }
    Box::new(source)
}

/// The disk, as long as its files are wanted: refusing them is the fastest way out of a check.
#[derive(Clone, Debug)]
struct WantedDisk {
    state: u64,
    wanted: Arc<AtomicU64>,
    /// Whether a file was refused.
    has_refused: Arc<AtomicBool>,
}

impl WantedDisk {
    fn is_wanted(&self) -> bool {
        self.wanted.load(Ordering::Relaxed) == self.state
    }
}

impl ReadSource for WantedDisk {
    fn read(&self, path: &Path) -> Result<Arc<str>, ReadError> {
        if self.is_wanted() {
            return DiskSource.read(path);
        }
        self.has_refused.store(true, Ordering::Relaxed);
        Err(ReadError::Io("no longer wanted".to_owned()))
    }

    fn exists(&self, path: &Path) -> bool {
        DiskSource.exists(path)
    }

    fn identity(&self, path: &Path) -> PathBuf {
        DiskSource.identity(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn task(name: &str) -> Task {
        let scope = Scope::Folder(name.into());
        Task { scope, files: Vec::new(), extent: Extent::Disk, offered: None, settings: Settings::default() }
    }

    fn check(task: &Task, _: &mut Option<Loaded>, source: &dyn Fn() -> Box<dyn ReadSource>) -> Outcome {
        assert_ne!(task.scope, Scope::Folder("bug".into()), "a bug in the analysis");
        let text = source().read(Path::new("/nowhere/a.rs"));
        Outcome::NotLoaded { message: text.map_or_else(|error| error.to_string(), |text| text.to_string()) }
    }

    fn run(state: u64, tasks: &[&str]) -> Vec<String> {
        let (events, inbox) = mpsc::channel();
        let checker = Checker::start(events, check);
        checker.want_newer();
        let buffers = vec![(PathBuf::from("/nowhere/a.rs"), Arc::from("text"))];
        checker.give(Job { state, tasks: tasks.iter().map(|name| task(name)).collect(), buffers });
        let Ok(Event::Checked(Checked { finished, dropped })) = inbox.recv() else { panic!("the thread answers") };
        let finished = finished.into_iter().map(|(_, outcome)| match outcome {
            Outcome::NotLoaded { message } => message,
            Outcome::Panicked { message } => format!("panic: {}", message.lines().next().unwrap_or_default()),
            other => panic!("{other:?}"),
        });
        finished.chain(dropped.into_iter().map(|_| "dropped".to_owned())).collect()
    }

    #[test]
    fn a_panic_costs_one_check() {
        let outcomes = run(1, &["bug", "next"]);
        assert!(outcomes[0].starts_with("panic: ") && outcomes[0].contains("a bug in the analysis"), "{outcomes:?}");
        assert_eq!(outcomes[1], "text");
    }

    #[test]
    fn an_old_state_is_not_checked() {
        assert_eq!(run(0, &["a", "b"]), ["dropped", "dropped"]);
    }

    #[test]
    fn files_of_an_old_state_are_refused() {
        let disk = WantedDisk { state: 0, wanted: Arc::new(AtomicU64::new(1)), has_refused: Arc::default() };
        assert!(matches!(disk.read(Path::new(file!())), Err(ReadError::Io(_))));
    }
}
