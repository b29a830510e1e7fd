//! Whatever the cycles of several tasks cost: each release before the end is run or counted as missed, never both.

#[path = "../common/random.rs"]
mod random;

use crate::Each;
use ceid_core::Time;
use ceid_core::prelude::*;
use ceid_core::thread::{Outcome, SuperloopCycleThread, Task, Until};
use core::time::Duration;
use random::Random;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// A clock that the cycles move. Its sleeps end too early or too late.
struct Moved<'n>(&'n AtomicU64, Random);

impl Time for Moved<'_> {
    fn now_ns(&mut self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }

    fn sleep_until_ns(&mut self, at_ns: u64) {
        let now_ns = self.now_ns();
        let slept_ns = (at_ns - now_ns) * (50 + self.1.below(60)) / 100 + 1;
        self.0.store(now_ns + slept_ns, Ordering::Relaxed);
    }
}

/// A task whose cycles cost up to `longest_ns`, and what its cycles were told.
fn task<'t, const HZ: u32>(
    now_ns: &'t AtomicU64,
    seen: &'t Mutex<Vec<CycleInfo>>,
    mut random: Random,
    overrun: Overrun,
) -> Task<impl RealtimeFunctionality<Rate = Hz<HZ>> + use<'t, HZ>> {
    let longest_ns = random.below(3_000_000_000 / u64::from(HZ)) + 1;
    let cycle = move |info: CycleInfo| {
        let late_ns = now_ns.fetch_add(random.below(longest_ns), Ordering::Relaxed) - START_NS - info.release_ns;
        assert_eq!(info.late_ns, late_ns);
        seen.lock().expect("no cycle panics").push(info);
        Flow::Continue
    };
    Task::new("task", Each::<HZ, _>(cycle), overrun)
}

const START_NS: u64 = 12_345;

fn check<F: RealtimeFunctionality>(task: &Task<F>, seen: &Mutex<Vec<CycleInfo>>, end_ns: u64) {
    let seen = seen.lock().expect("no cycle panics");
    let mut next = 0;
    for info in seen.iter() {
        assert_eq!(info.n, next + info.missed, "each release is run or missed");
        assert_eq!(info.release_ns, F::Rate::release_ns(info.n));
        next = info.n + 1;
    }
    assert_eq!(task.cycles(), seen.len() as u64);
    assert_eq!(task.cycles() + task.missed(), task.released());
    match task.outcome() {
        Some(Outcome::Completed) => {
            assert_eq!(task.released(), (0..).take_while(|n| F::Rate::release_ns(*n) < end_ns).count() as u64);
        }
        Some(Outcome::Overran) => assert!(task.missed() >= 2),
        outcome => assert_eq!(outcome, Some(Outcome::EndedByAnother)),
    }
}

#[test]
fn each_release_of_each_task_is_run_or_missed() {
    for seed in 0..500 {
        let mut random = Random::new(seed);
        let now_ns = AtomicU64::new(START_NS);
        let (seen_30, seen_100, seen_1000) = Default::default();
        let mut overrun = || match random.below(4) {
            0 => Overrun::Stop,
            1 => Overrun::CatchUp { max: 3 },
            2 => Overrun::CatchUp { max: u32::MAX },
            _ => Overrun::Skip,
        };
        let overruns = [overrun(), overrun(), overrun()];
        let mut vision = task::<30>(&now_ns, &seen_30, Random::new(seed + 1000), overruns[0]);
        let mut motor = task::<100>(&now_ns, &seen_100, Random::new(seed + 2000), overruns[1]);
        let mut sensors = task::<1000>(&now_ns, &seen_1000, Random::new(seed + 3000), overruns[2]);
        let end_ns = random.below(300_000_000);
        let mut thread = SuperloopCycleThread::new(Moved(&now_ns, Random::new(seed + 4000)));
        thread.run(&mut [&mut vision, &mut motor, &mut sensors], Until::duration(Duration::from_nanos(end_ns)));
        check(&vision, &seen_30, end_ns);
        check(&motor, &seen_100, end_ns);
        check(&sensors, &seen_1000, end_ns);
    }
}
