//! What may hold filters, in which order they are updated, and at which rates.

use ceid_core::prelude::*;
use ceid_core::{Divider, filter::Registers};

mod common;
use common::{Log, Logged};

/// Runs some cycles of a set at 12 Hz and compares the log.
#[track_caller]
fn check(set: impl FnOnce(&Log) -> Box<dyn FnMut()>, expected: &str) {
    let log = Log::default();
    set(&log)();
    assert_eq!(log.take(), expected);
}

/// A loop of `cycles` empty cycles.
fn idle(set: impl SampledFilter<Hz<12>> + 'static, cycles: u64) -> Box<dyn FnMut()> {
    let mut control = Cyclic::new(set, Free::new().take(cycles));
    Box::new(move || each_cycle!(_f in control => {}))
}

#[test]
fn declaration_is_order() {
    filters! { struct Set @ 12 Hz { c: Logged; a: Logged; b: Logged; } }
    check(|log| idle(Set::register(log.filter("c"), log.filter("a"), log.filter("b")), 2), "c a b c a b");
}

#[test]
fn tuples_arrays_options_and_references() {
    check(
        |log| {
            let set = (
                log.filter("a"),
                [log.filter("b"), log.filter("c")],
                Some(log.filter("d")),
                None::<Logged>,
                Box::leak(Box::new(log.filter("e"))),
                &mut *vec![log.filter("f"), log.filter("g")].leak(),
            );
            idle(set, 1)
        },
        "a b c d e f g",
    );
}

#[cfg(feature = "alloc")]
#[test]
fn boxes_and_vectors() {
    check(
        |log| {
            let boxed: Box<dyn SampledFilter<Hz<12>>> = Box::new(log.filter("b"));
            idle((vec![log.filter("a")], boxed), 2)
        },
        "a b a b",
    );
}

#[test]
fn composites_pass_the_tick_on() {
    struct Axis {
        inner: Logged,
        slow: Logged,
        divider: Divider<Hz<6>>,
        rest: [Logged; 2],
    }
    impl SampledFilter<Hz<12>> for Axis {
        fn update(&mut self, tick: Tick<'_, Hz<12>>) {
            tick.then(&mut self.inner).every(&mut self.divider, &mut self.slow).each(&mut self.rest).done();
        }
    }
    let axis = |log: &Log| Axis {
        inner: log.filter("i"),
        slow: log.filter("s"),
        divider: Divider::new(),
        rest: [log.filter("x"), log.filter("y")],
    };
    check(|log| idle(axis(log), 3), "i s x y i x y i s x y");
}

#[test]
fn every_n_runs_in_the_first_cycle_and_then_in_each_nth() {
    filters! {
        struct Set @ 12 Hz {
            slow: Logged, every 3;
            fast: Logged;
            slower: Logged, every 4;
            once_a_second: Logged, every 12;
            each: Logged, every 1;
        }
    }
    check(
        |log| {
            let [slow, fast, slower, once_a_second, each] = ["3", ".", "4", "12", "1"].map(|name| log.filter(name));
            idle(Set::register(slow, fast, slower, once_a_second, each), 13)
        },
        "3 . 4 12 1 . 1 . 1 3 . 1 . 4 1 . 1 3 . 1 . 1 . 4 1 3 . 1 . 1 . 1 3 . 4 12 1",
    );
}

#[test]
fn sets_nest() {
    filters! { struct Inner @ 6 Hz { a: Logged; b: Logged, every 2 } }
    filters! { struct Outer @ 12 Hz { c: Logged; inner: Inner, every 2 } }
    check(
        |log| idle(Outer::register(log.filter("c"), Inner::register(log.filter("a"), log.filter("b"))), 4),
        "c a b c c a c",
    );
}

/// Adds up its step; the sum is the time that the filter believes has passed.
#[derive(Debug, Default, Clone, PartialEq)]
struct Time(f64);

impl<R: Rate> SampledFilter<R> for Time {
    fn update(&mut self, tick: Tick<'_, R>) {
        assert!((tick.dt() - f64::from(tick.dt_f32())).abs() < 1e-8);
        assert!((tick.dt() - 1.0 / f64::from(tick.hz())).abs() < 1e-12);
        self.0 += tick.dt();
    }
}

filters! {
    /// Attributes and visibilities are those of a struct.
    #[derive(Debug, Clone, PartialEq)]
    pub(crate) struct Times @ 1000 Hz {
        /// Every millisecond.
        pub(crate) fast: Time;
        pub slow: Time, every 100;
        hold: Option<Time>
    }
}

#[test]
fn a_divided_filter_gets_the_longer_step() {
    let mut control = Cyclic::new(Times::register(Time(0.0), Time(0.0), None), Free::<Hz<1000>>::new().take(1000));
    each_cycle!(_f in control => {});
    let (times, _) = control.into_parts();
    assert!((times.fast.0 - 1.0).abs() < 1e-9, "{times:?}");
    assert!((times.slow.0 - 1.0).abs() < 1e-9, "{times:?}");
    assert_eq!(times.hold, None);
}

#[test]
fn a_set_can_be_a_static() {
    static TIMES: std::sync::Mutex<Times> = std::sync::Mutex::new(Times::register_const(Time(0.0), Time(0.0), None));
    let mut times = TIMES.lock().unwrap();
    each_cycle!(_f in Cyclic::new(&mut *times, Free::<Hz<1000>>::new().take(2)) => {});
    assert_eq!(times.slow, Time(0.1));
}

filters! { struct Asserted @ 1000 Hz { time: Time; log: Logged; slow: Option<Time>, every 10 } }
assert_updated_once!(Asserted, Time);
assert_updated_once!(Asserted, Logged);
assert_updated_once!(Asserted, Option<Time>);

#[test]
fn registration_can_be_asked_for_in_a_bound() {
    fn logs<Field>(_: &impl Registers<Logged, Field>) {}
    logs(&Asserted::register(Time(0.0), Log::default().filter("a"), None));
}

#[test]
fn ticks_and_rates_take_no_space() {
    assert_eq!(size_of::<Tick<'_, Hz<1000>>>(), 0);
    assert_eq!(size_of::<Hz<1000>>(), 0);
    assert_eq!(size_of::<Divider<Hz<10>>>(), 4);
    assert_eq!(size_of::<Cyclic<(), Free<Hz<10>>>>(), 8);
}
