//! Rates, release times and the clocks that only count.

use ceid_core::prelude::*;

#[test]
fn release_times_are_the_exact_quotient_rounded_down() {
    #[track_caller]
    fn check<R: Rate>() {
        for n in [0, 1, 2, 29, 30, 31, 999_999, 3_000_001, 1 << 53] {
            let exact = u128::from(n) * 1_000_000_000 / u128::from(R::HZ);
            assert_eq!(u128::from(R::release_ns(n)), exact.min(u128::from(u64::MAX)), "n = {n} at {:?}", R::HZ);
        }
    }
    check::<Hz<1>>();
    check::<Hz<3>>();
    check::<Hz<30>>();
    check::<Hz<44_100>>();
    check::<Hz<999_983>>();
    check::<Hz<{ u32::MAX }>>();
}

#[test]
fn release_times_saturate() {
    assert_eq!(Hz::<1>::release_ns(u64::MAX), u64::MAX);
}

#[test]
fn a_rate_may_have_a_name() {
    #[derive(Debug, Clone, Copy)]
    struct Motors;
    impl Rate for Motors {
        const HZ: u32 = 100;
    }
    assert_eq!(Motors::DT, 0.01);
    assert_eq!(Motors::release_ns(3), 30_000_000);
}

#[test]
fn a_free_clock_reports_nominal_times() {
    let mut clock = Free::<Hz<3>>::new().take(3);
    let mut seen = Vec::new();
    while let Some(cycle) = clock.next_cycle() {
        seen.push(cycle.info());
    }
    let nominal = |n, release_ns| CycleInfo { n, release_ns, late_ns: 0, missed: 0 };
    assert_eq!(seen, [nominal(0, 0), nominal(1, 333_333_333), nominal(2, 666_666_666)]);
    assert!(clock.wait().is_none());
}

/// Every third release is missed.
struct Late(u64);

impl Clock for Late {
    type Rate = Hz<1000>;

    fn wait(&mut self) -> Option<CycleInfo> {
        let missed = u64::from(self.0 % 3 == 1);
        let n = self.0 + missed;
        self.0 = n + 1;
        Some(CycleInfo { n, release_ns: Hz::<1000>::release_ns(n), late_ns: 0, missed })
    }
}

#[test]
fn a_missed_release_does_not_swallow_the_update_of_a_slower_filter() {
    struct Count(u32);
    impl<R: Rate> SampledFilter<R> for Count {
        fn update(&mut self, _: Tick<'_, R>) {
            self.0 += 1;
        }
    }
    filters! { struct Set @ 1000 Hz { fast: Count; slow: Count, every 10 } }
    let mut control = Cyclic::new(Set::register(Count(0), Count(0)), Late(0).take(100));
    let (mut run, mut missed, mut last) = (0, 0, 0);
    each_cycle!(_f, info in control => {
        run += 1;
        missed += info.missed;
        last = info.n;
    });
    assert_eq!(run + missed, last + 1);
    assert_eq!((control.filters().fast.0, control.filters().slow.0), (100, 10));
}
