//! Each registered filter is updated once in each entered cycle, in order, on every way out, in all forms of the guard.

#![expect(clippy::never_loop, reason = "several cases leave the loop in its first cycle")]

use ceid_core::prelude::*;
use core::ops::ControlFlow::{Break, Continue};
use std::panic::{AssertUnwindSafe, catch_unwind};

mod common;
use common::{Log, Logged};

filters! { struct Filters @ 1000 Hz { kf: Logged; pf: Logged } }

type Control = Cyclic<Filters, Free<Hz<1000>>>;

/// Runs a loop and compares what the body and the update laws have written.
#[track_caller]
fn check(body: impl FnOnce(&mut Control, &Log), expected: &str) {
    let log = Log::default();
    let filters = Filters::register(log.filter("kf"), log.filter("pf"));
    let mut control = Cyclic::new(filters, Free::new());
    body(&mut control, &log);
    assert_eq!(log.take(), expected);
}

#[test]
fn the_end_of_the_body() {
    check(
        |control, log| {
            each_cycle!(f, info in control => {
                f.kf.read();
                log.push("body");
                if info.n == 1 { break }
            });
        },
        "body kf pf body kf pf",
    );
}

#[test]
fn continue_statement() {
    check(
        |control, log| {
            each_cycle!(_f, info in control => {
                match info.n {
                    0 => continue,
                    1 => log.push("body"),
                    _ => break,
                }
            });
        },
        "kf pf body kf pf kf pf",
    );
}

#[test]
fn labelled_break_and_continue() {
    check(
        |control, log| {
            let mut rounds = 0;
            'outer: loop {
                rounds += 1;
                log.push("round");
                each_cycle!(_f in control => {
                    match rounds {
                        1 | 2 => continue 'outer,
                        _ => break 'outer,
                    }
                });
            }
        },
        "round kf pf round kf pf round kf pf",
    );
}

#[test]
fn return_statement() {
    fn lap(control: &mut Control) -> u8 {
        each_cycle!(_f in control => { return 7 });
        0
    }
    check(|control, _| assert_eq!(lap(control), 7), "kf pf");
}

#[test]
fn question_mark() {
    fn lap(control: &mut Control) -> Option<()> {
        each_cycle!(f, info in control => {
            let _sample = [1.0, 2.0].get(info.n as usize)?;
            f.kf.read();
        });
        Some(())
    }
    check(|control, _| assert!(lap(control).is_none()), "kf pf kf pf kf pf");
}

#[test]
fn panic_in_the_body() {
    check(
        |control, _| {
            let outcome = catch_unwind(AssertUnwindSafe(|| {
                each_cycle!(_f in control => { std::panic::resume_unwind(Box::new("sensor")) });
            }));
            assert!(outcome.is_err());
        },
        "kf pf",
    );
}

#[test]
fn a_panic_in_a_law_leaves_the_laws_after_it_unrun_and_the_driver_usable() {
    struct Fails(bool);
    impl<R: Rate> SampledFilter<R> for Fails {
        fn update(&mut self, _: Tick<'_, R>) {
            if self.0 {
                std::panic::resume_unwind(Box::new("law"))
            }
        }
    }
    let log = Log::default();
    let mut control = Cyclic::new((log.filter("a"), Fails(true), log.filter("b")), Free::<Hz<1000>>::new().take(2));
    let outcome = catch_unwind(AssertUnwindSafe(|| each_cycle!(_f in control => {})));
    assert!(outcome.is_err());
    assert_eq!(log.take(), "a");
    each_cycle!(f in control => { f.1.0 = false });
    assert_eq!(log.take(), "a b");
}

#[test]
fn the_end_of_the_clock_enters_no_cycle() {
    let log = Log::default();
    let mut control = Cyclic::new([log.filter("a")], Free::<Hz<10>>::new().take(2));
    each_cycle!(_f in control => {});
    assert_eq!(log.take(), "a a");
    assert!(control.cycle().is_none());
    assert_eq!(log.take(), "");
}

#[test]
fn closure_form() {
    check(
        |control, log| {
            let found = control.run(|f, info| {
                f.pf.read();
                log.push("body");
                if info.n == 2 { Break(info.n) } else { Continue(()) }
            });
            assert_eq!(found, Some(2));
        },
        "body kf pf body kf pf body kf pf",
    );
    check(
        |control, _| {
            assert!(
                catch_unwind(AssertUnwindSafe(|| control
                    .run(|_, _| -> core::ops::ControlFlow<()> { std::panic::resume_unwind(Box::new("sensor")) })))
                .is_err()
            );
        },
        "kf pf",
    );
}

#[test]
fn named_form() {
    check(
        |control, log| {
            while let Some(mut guard) = control.cycle() {
                let n = guard.info().n;
                let f = guard.filters();
                f.kf.read();
                f.pf.read();
                log.push("body");
                if n == 0 {
                    continue;
                }
                break;
            }
        },
        "body kf pf body kf pf",
    );
}

#[test]
fn migration_form() {
    fn lap(kf: &mut Logged, pfs: &mut (Logged, Logged), log: &Log) -> Option<()> {
        let mut clock = Free::<Hz<1000>>::new();
        while let Some(cycle) = clock.next_cycle() {
            let info = cycle.info();
            ceid!(cycle => kf, last = pfs.1, first = pfs.0);
            kf.read();
            first.read();
            last.read();
            if info.n == 0 {
                continue;
            }
            log.push("body");
            [(); 2].get(info.n as usize)?;
        }
        Some(())
    }
    let log = Log::default();
    let mut kf = log.filter("kf");
    let mut pfs = (log.filter("pf0"), log.filter("pf1"));
    assert!(catch_unwind(AssertUnwindSafe(|| lap(&mut kf, &mut pfs, &log))).is_ok());
    assert_eq!(log.take(), "kf pf1 pf0 body kf pf1 pf0 body kf pf1 pf0");
}

#[test]
fn migration_form_on_panic() {
    let log = Log::default();
    let mut kf = log.filter("kf");
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        let mut clock = Free::<Hz<1000>>::new();
        while let Some(cycle) = clock.next_cycle() {
            ceid!(cycle => kf);
            kf.read();
            std::panic::resume_unwind(Box::new("sensor"))
        }
    }));
    assert!(outcome.is_err());
    assert_eq!(log.take(), "kf");
}

#[test]
fn the_driver_may_be_a_field_or_a_new_value() {
    struct Robot {
        control: Control,
    }
    let log = Log::default();
    let mut robot = Robot { control: Cyclic::new(Filters::register(log.filter("kf"), log.filter("pf")), Free::new()) };
    each_cycle!(f in robot.control => {
        f.kf.read();
        break;
    });
    assert_eq!(log.take(), "kf pf");
    each_cycle!(_f in Cyclic::new(log.filter("x"), Free::<Hz<1>>::new().take(2)) => {});
    assert_eq!(log.take(), "x x");
}

#[test]
fn the_migration_form_takes_whatever_lends_its_filter() {
    let log = Log::default();
    let cell = std::cell::RefCell::new(log.filter("cell"));
    let lock = std::sync::Mutex::new(log.filter("lock"));
    let mut boxed = Box::new(log.filter("boxed"));
    let mut owned = [log.filter("first"), log.filter("second")];
    let mut present = Some(log.filter("present"));
    let mut clock = Free::<Hz<1000>>::new().take(1);
    while let Some(cycle) = clock.next_cycle() {
        let mut lock = lock.lock().unwrap();
        let mut cell = cell.borrow_mut();
        let slice = &mut owned[..];
        ceid!(cycle => cell, lock, boxed, slice, present,);
        cell.read();
        lock.read();
        slice[0].read();
        *present = None;
        log.push("body");
    }
    assert_eq!(log.take(), "body cell lock boxed first second");
}

#[cfg(feature = "alloc")]
#[test]
fn the_migration_form_takes_a_boxed_trait_object() {
    let log = Log::default();
    let mut boxed: Box<dyn SampledFilter<Hz<1000>>> = Box::new(log.filter("boxed"));
    let mut clock = Free::<Hz<1000>>::new().take(2);
    while let Some(cycle) = clock.next_cycle() {
        ceid!(cycle => boxed);
    }
    assert_eq!(log.take(), "boxed boxed");
}

#[test]
fn the_migration_form_takes_sixteen_filters() {
    let log = Log::default();
    let [
        mut a,
        mut b,
        mut c,
        mut d,
        mut e,
        mut f,
        mut g,
        mut h,
        mut i,
        mut j,
        mut k,
        mut l,
        mut m,
        mut n,
        mut o,
        mut p,
    ] = ["a", "b", "c", "d", "e", "f", "g", "h", "i", "j", "k", "l", "m", "n", "o", "p"].map(|name| log.filter(name));
    let mut clock = Free::<Hz<1000>>::new().take(1);
    while let Some(cycle) = clock.next_cycle() {
        ceid!(cycle => a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p);
    }
    assert_eq!(log.take(), "a b c d e f g h i j k l m n o p");
}
