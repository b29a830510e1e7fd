//! Releases are counted in exact integers: none is lost, and none is run twice, however late the cycles are.

use ceid_core::prelude::*;
use ceid_core::{Releases, Time};

mod common;
use common::random::Random;

/// Every release that is due by `now`, one by one: what [`Rate::released_by`] must agree with.
fn due<R: Rate>(now_ns: u64) -> u64 {
    (0..).take_while(|&n| R::release_ns(n) <= now_ns).count() as u64
}

#[test]
fn released_by_is_the_inverse_of_release_ns() {
    #[track_caller]
    fn check<R: Rate>() {
        let mut random = Random::new(u64::from(R::HZ));
        for _ in 0..2_000 {
            let n = random.next() >> random.below(30);
            let release_ns = R::release_ns(n);
            if release_ns == u64::MAX {
                continue;
            }
            assert!(R::released_by(release_ns) > n, "release {n} at {} Hz", R::HZ);
            if release_ns > 0 {
                let earlier = R::released_by(release_ns - 1);
                assert!(earlier <= n, "release {n} at {} Hz: {earlier} are due before it", R::HZ);
            }
            assert!(R::release_ns(n.saturating_add(1)) >= release_ns);
        }
        assert_eq!(R::released_by(0), u64::from(R::HZ).div_ceil(1_000_000_000));
    }
    check::<Hz<1>>();
    check::<Hz<3>>();
    check::<Hz<30>>();
    check::<Hz<1000>>();
    check::<Hz<44_100>>();
    check::<Hz<999_983>>();
    check::<Hz<1_000_000_000>>();
    check::<Hz<{ u32::MAX }>>();
    for now_ns in [0, 1, 33_333_332, 33_333_333, 33_333_334, 999_999_999, 1_000_000_000, 1_000_000_001] {
        assert_eq!(Hz::<30>::released_by(now_ns), due::<Hz<30>>(now_ns), "at {now_ns} ns");
    }
    assert_eq!(Hz::<1000>::released_by(u64::MAX), 18_446_744_073_710);
}

/// A time that moves when somebody sleeps, and by as much as the cycles are said to take. Sleeps may end late.
#[derive(Clone)]
struct Simulated {
    now_ns: u64,
    oversleep_ns: u64,
}

impl Time for Simulated {
    fn now_ns(&mut self) -> u64 {
        self.now_ns
    }

    fn sleep_until_ns(&mut self, at_ns: u64) {
        self.now_ns = self.now_ns.max(at_ns) + self.oversleep_ns;
    }
}

#[test]
fn cycles_and_missed_releases_are_all_releases() {
    #[track_caller]
    fn check<R: Rate>(overrun: Overrun, seed: u64) {
        let mut random = Random::new(seed);
        let mut releases = Releases::<R>::new(overrun);
        let (mut now_ns, mut ran, mut missed) = (random.below(1 << 33), 0, 0);
        let mut last: Option<CycleInfo> = None;
        for _ in 0..3_000 {
            let before = releases.clone();
            let due = R::released_by(now_ns).max(before.released() + 1);
            let Some(info) = releases.begin(now_ns) else {
                assert_eq!(overrun, Overrun::Stop);
                assert_eq!(releases.released(), due, "all releases up to the stop are counted");
                assert_eq!(releases.missed(), due - ran, "none of those that the stop was about has run");
                assert!(releases.missed() > 1 && releases.is_stopped());
                assert_eq!(releases.begin(now_ns), None);
                break;
            };
            ran += 1;
            missed += info.missed;
            assert_eq!((releases.cycles(), releases.missed()), (ran, missed));
            assert_eq!(ran + missed, releases.released());
            assert_eq!(info.n + 1, releases.released());
            assert_eq!(info.n, last.map_or(0, |last| last.n + 1) + info.missed);
            assert_eq!(info.release_ns, R::release_ns(info.n));
            assert_eq!(info.late_ns, now_ns.saturating_sub(info.release_ns));
            let waiting = due - releases.released();
            match overrun {
                Overrun::Skip => assert_eq!(waiting, 0, "the latest release runs"),
                Overrun::CatchUp { max } => {
                    assert!(waiting <= u64::from(max));
                    assert!(info.missed == 0 || waiting == u64::from(max), "none is missed that could wait");
                }
                Overrun::Stop => assert_eq!((info.missed, waiting), (0, 0)),
            }
            last = Some(info);
            // The cycle takes a part of its period, or much longer; then the clock sleeps, if there is time left.
            let period_ns = R::release_ns(1);
            now_ns += match random.below(8) {
                0 => random.below(5 * period_ns + 1),
                _ => random.below(period_ns),
            };
            now_ns = now_ns.max(releases.next_ns()) + random.below(period_ns / 50 + 1);
        }
    }
    for seed in 0..40 {
        for overrun in [
            Overrun::Skip,
            Overrun::CatchUp { max: 0 },
            Overrun::CatchUp { max: 1 },
            Overrun::CatchUp { max: 3 },
            Overrun::CatchUp { max: u32::MAX },
            Overrun::Stop,
        ] {
            check::<Hz<3>>(overrun, seed);
            check::<Hz<30>>(overrun, seed);
            check::<Hz<1000>>(overrun, seed);
            check::<Hz<999_983>>(overrun, seed);
        }
    }
}

#[test]
fn a_burst_is_as_long_as_the_choice_allows() {
    /// The numbers of the cycles that begin at 10 ms and then one after the other until the clock would sleep.
    fn burst(overrun: Overrun) -> Vec<u64> {
        let mut releases = Releases::<Hz<1000>>::new(overrun);
        assert_eq!(releases.begin(0).map(|info| info.n), Some(0));
        let mut burst = Vec::new();
        while releases.next_ns() <= 10_000_000 {
            let Some(info) = releases.begin(10_000_000) else { break };
            burst.push(info.n);
        }
        burst
    }
    assert_eq!(burst(Overrun::Skip), [10]);
    assert_eq!(burst(Overrun::CatchUp { max: 0 }), [10]);
    assert_eq!(burst(Overrun::CatchUp { max: 2 }), [8, 9, 10]);
    assert_eq!(burst(Overrun::CatchUp { max: 100 }), [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]);
    assert_eq!(burst(Overrun::Stop), []);
}

#[test]
fn a_release_begun_before_it_is_due_is_not_late() {
    let mut releases = Releases::<Hz<10>>::new(Overrun::Stop);
    releases.begin(0);
    let info = releases.begin(3).expect("no overrun");
    assert_eq!((info.n, info.release_ns, info.late_ns, info.missed), (1, 100_000_000, 0, 0));
}

#[test]
fn the_first_wait_is_release_zero() {
    let time = Simulated { now_ns: 77_000_000_000, oversleep_ns: 40 };
    let mut clock = Periodic::<Hz<1000>, _>::new(time, Overrun::Skip);
    let infos: Vec<_> = core::iter::from_fn(|| clock.wait()).take(3).collect();
    let late = |n, late_ns| CycleInfo { n, release_ns: n * 1_000_000, late_ns, missed: 0 };
    assert_eq!(infos, [late(0, 0), late(1, 40), late(2, 40)], "lateness does not add up");
}

/// Writes down its steps.
struct Steps(Vec<f64>);

impl<R: Rate> SampledFilter<R> for Steps {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0.push(tick.dt());
    }
}

#[test]
fn nominal_steps_stay_nominal_when_cycles_are_late() {
    let time = Simulated { now_ns: 0, oversleep_ns: 2_700_000 };
    let mut control = Cyclic::new(Steps(Vec::new()), Periodic::<Hz<1000>, _>::new(time, Overrun::Skip).take(5));
    let mut late = Vec::new();
    each_cycle!(_f, info in control => { late.push((info.late_ns, info.missed)) });
    assert_eq!(control.filters().0, [0.001; 5]);
    assert_eq!(late, [(0, 0), (700_000, 2), (700_000, 2), (700_000, 2), (700_000, 2)]);
}

#[test]
fn an_overrun_ends_a_loop_that_wants_it() {
    let time = Simulated { now_ns: 0, oversleep_ns: 1_000_000 };
    let mut control = Cyclic::new(None::<Steps>, Periodic::<Hz<1000>, _>::new(time, Overrun::Stop));
    let mut cycles = 0;
    each_cycle!(_f in control => { cycles += 1 });
    assert_eq!(cycles, 1);
    let releases = control.clock().releases();
    assert_eq!((releases.cycles(), releases.missed(), releases.released()), (1, 2, 3));
    assert!(releases.is_stopped() && control.cycle().is_none());
}

#[cfg(feature = "std")]
#[test]
fn the_standard_library_keeps_the_rate() {
    let mut clock = Periodic::<Hz<1000>, _>::new(StdTime::new(), Overrun::Skip);
    let begin = std::time::Instant::now();
    let mut last = 0;
    while last < 20 {
        last = clock.wait().expect("it never ends").n;
    }
    assert!(begin.elapsed().as_millis() >= 20);
    let releases = clock.releases();
    assert_eq!(releases.cycles() + releases.missed(), releases.released());
}
