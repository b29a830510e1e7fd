//! The loop of every world: waits for the earliest release, runs its cycle. Only how it waits differs.

use super::{CyclicTask, Outcome, Until};
use crate::cycle::Time;

/// Begins a run of all tasks; if one of them cannot run, none does.
pub(super) fn start(tasks: &mut [&mut dyn CyclicTask], until: &Until<'_>) {
    let mut can_run = true;
    tasks.iter_mut().for_each(|task| can_run &= task.start(until.duration_ns));
    if !can_run {
        tasks.iter_mut().for_each(|task| task.end(Outcome::EndedByAnother));
    }
}

/// Runs the tasks in this thread, one cycle at a time, by the time of their releases and then in the order given.
/// Returns whether all of them have run to the end.
pub(super) fn run(tasks: &mut [&mut dyn CyclicTask], time: &mut impl Time, start_ns: u64, until: Until<'_>) -> bool {
    // The others are ended also if a cycle unwinds.
    let tasks = EndsAll(tasks);
    while let Some((task, others_ns)) = earliest(tasks.0) {
        // As long as no other task is due, none of them has to be asked.
        while let Some((_, release_ns)) = task.next_release() {
            let Ok(now_ns) = wait(time, start_ns.saturating_add(release_ns), &until) else {
                let outcome = if until.is_stop_requested() { Outcome::Stopped } else { Outcome::EndedByAnother };
                tasks.0.iter_mut().for_each(|task| task.end(outcome));
                return false;
            };
            if !task.run_cycle(now_ns.saturating_sub(start_ns)) {
                return false;
            }
            if task.next_release().is_none_or(|(_, release_ns)| release_ns >= others_ns) {
                break;
            }
        }
    }
    true
}

/// An end of the run was asked for.
struct Ended;

/// Returns what time it is, once it is `deadline_ns`.
fn wait(time: &mut impl Time, deadline_ns: u64, until: &Until<'_>) -> Result<u64, Ended> {
    loop {
        if until.is_stop_requested() || until.is_ended() {
            return Err(Ended);
        }
        let now_ns = time.now_ns();
        if now_ns >= deadline_ns {
            return Ok(now_ns);
        }
        time.sleep_until_ns(deadline_ns);
    }
}

/// The task with the earliest release, the first of several, and when the next of the others is due; `None` when all have
/// ended.
fn earliest<'t, 's>(tasks: &'t mut [&'s mut dyn CyclicTask]) -> Option<(&'t mut (dyn CyclicTask + 's), u64)> {
    let mut earliest: Option<(usize, Release)> = None;
    let mut others_ns = u64::MAX;
    for (at, task) in tasks.iter().enumerate() {
        let Some((n, ns)) = task.next_release() else { continue };
        let release = Release { n, ns, hz: task.hz() };
        let later = match &earliest {
            Some((_, first)) if !release.is_before(first) => Some(release),
            _ => earliest.replace((at, release)).map(|(_, later)| later),
        };
        others_ns = later.map_or(others_ns, |later| later.ns.min(others_ns));
    }
    let (at, _) = earliest?;
    Some((&mut **tasks.get_mut(at)?, others_ns))
}

/// Release `n` of a task, with its time rounded down.
struct Release {
    n: u64,
    ns: u64,
    hz: u32,
}

impl Release {
    /// Exact: release n of a task at `hz` is due at n / hz, and two such times are compared by their cross products.
    fn is_before(&self, other: &Self) -> bool {
        let product = |n: u64, hz: u32| u128::from(n) * u128::from(hz);
        self.ns < other.ns || self.ns == other.ns && product(self.n, other.hz) < product(other.n, self.hz)
    }
}

struct EndsAll<'r, 't>(&'r mut [&'t mut dyn CyclicTask]);

impl Drop for EndsAll<'_, '_> {
    fn drop(&mut self) {
        self.0.iter_mut().for_each(|task| task.end(Outcome::EndedByAnother));
    }
}
