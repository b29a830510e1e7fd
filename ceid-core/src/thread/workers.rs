//! A thread of the operating system for each task: made, prepared, begun together, and joined.

use core::slice;
use std::io;
use std::panic::resume_unwind;
use std::sync::mpsc;
use std::thread::{self, Builder, ScopedJoinHandle};
use std::vec::Vec;

use super::{CyclicTask, Granted, Outcome, Privilege, Privileges, StopSignal, Until, cooperative};
use crate::cycle::Time;

/// How a world of threads differs from the others.
pub(super) trait Workers: Sync {
    type Time: Time;

    /// Called in the thread of a task before the run: asks for its privileges.
    fn prepare(&self, name: &'static str, hz: u32) -> Granted;

    /// Whether the run begins with these.
    fn may_begin(&self, granted: &[Granted]) -> bool;

    /// The clock of one thread; all of them tell the same time.
    fn time(&self) -> Self::Time;
}

/// How far ahead release 0 is when the threads are told of it: far enough that all of them wait for it, although the
/// first of them may preempt the thread that tells the others.
const START_AHEAD_NS: u64 = 5_000_000;

/// Runs each task in its own thread. Says whether the threads could be made, and what each of them was granted.
pub(super) fn run(tasks: &mut [&mut dyn CyclicTask], world: &impl Workers, until: Until<'_>) -> Privileges {
    cooperative::start(tasks, &until);
    let end = StopSignal::new();
    let until = until.or_ended(&end);
    let mut threads_made = Privilege::Granted;
    let (threads, panic) = thread::scope(|scope| {
        let mut workers = Vec::with_capacity(tasks.len());
        for task in tasks.iter_mut() {
            match Worker::spawn(scope, &mut **task, world, until, &end) {
                Ok(worker) => workers.push(worker),
                Err(error) => {
                    threads_made = Privilege::of(Err(error));
                    break;
                }
            }
        }
        let threads: Vec<_> = workers.iter().filter_map(|worker| worker.granted.recv().ok()).collect();
        // All threads are ready; without a start they end.
        if threads_made == Privilege::Granted && world.may_begin(&threads) {
            let start_ns = world.time().now_ns().saturating_add(START_AHEAD_NS);
            for worker in &workers {
                // Fails only if the thread has gone, which its handle tells below.
                let _ = worker.start.send(start_ns);
            }
        }
        let mut panic = None;
        for handle in workers.into_iter().map(Worker::into_handle) {
            if let Err(payload) = handle.join() {
                panic.get_or_insert(payload);
            }
        }
        (threads, panic)
    });
    tasks.iter_mut().for_each(|task| task.end(Outcome::NotStarted));
    if let Some(payload) = panic {
        resume_unwind(payload);
    }
    Privileges { threads_made, threads, ..Privileges::default() }
}

struct Worker<'scope> {
    handle: ScopedJoinHandle<'scope, ()>,
    granted: mpsc::Receiver<Granted>,
    start: mpsc::Sender<u64>,
}

impl<'scope> Worker<'scope> {
    fn spawn<'env>(
        scope: &'scope thread::Scope<'scope, 'env>,
        task: &'scope mut dyn CyclicTask,
        world: &'scope impl Workers,
        until: Until<'scope>,
        end: &'scope StopSignal,
    ) -> io::Result<Self> {
        let (send_granted, granted) = mpsc::channel();
        let (start, receive_start) = mpsc::channel();
        let mut builder = Builder::new();
        // A name with a NUL would make the library panic.
        if !task.name().contains('\0') {
            builder = builder.name(task.name().into());
        }
        let work = move || {
            if send_granted.send(world.prepare(task.name(), task.hz())).is_err() {
                return;
            }
            let Ok(start_ns) = receive_start.recv() else { return };
            // Raised by a panic as well.
            let ends_the_others = RaisesOnDrop(end);
            let mut task = task;
            if cooperative::run(slice::from_mut(&mut task), &mut world.time(), start_ns, until) {
                core::mem::forget(ends_the_others);
            }
        };
        let handle = builder.spawn_scoped(scope, work)?;
        Ok(Self { handle, granted, start })
    }

    /// Also closes the channels, which ends a thread that waits for its start.
    fn into_handle(self) -> ScopedJoinHandle<'scope, ()> {
        self.handle
    }
}

struct RaisesOnDrop<'s>(&'s StopSignal);

impl Drop for RaisesOnDrop<'_> {
    fn drop(&mut self) {
        self.0.raise();
    }
}
