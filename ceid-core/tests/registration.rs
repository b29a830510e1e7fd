//! Filters that are born unregistered, filters with several users, and measurements that count once.

#![cfg(feature = "alloc")]

use ceid_core::filter::AlreadyRegistered;
use ceid_core::prelude::*;
use ceid_core::{OnlyInCeid, Shared};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::rc::Rc;

mod common;
use common::{Log, Logged};

filters! { struct Pair @ 10 Hz { a: Logged; b: Logged } }

fn idle(set: impl SampledFilter<Hz<10>>, cycles: u64) {
    each_cycle!(_f in Cyclic::new(set, Free::<Hz<10>>::new().take(cycles)) => {});
}

#[test]
fn a_set_takes_filters_and_unregistered_filters() {
    let log = Log::default();
    idle(Pair::register(log.filter("a"), Unregistered::new(log.filter("b"))), 2);
    assert_eq!(log.take(), "a b a b");
}

#[test]
fn unregistered_filters_are_built_into_composites() {
    filters! { struct Set @ 10 Hz { wheels: [Logged; 2]; many: Vec<Logged>; pair: Pair; boxed: Box<dyn SampledFilter<Hz<10>>> } }
    let log = Log::default();
    let wheels = Unregistered::array(|index| Unregistered::new(log.filter(["left", "right"][index])));
    let many =
        ["x", "y", "z"].map(|name| log.filter(name)).into_iter().map(Unregistered::new).collect::<Unregistered<_>>();
    let pair =
        Unregistered::new(log.filter("a")).zip(Unregistered::new(log.filter("b"))).map(|(a, b)| Pair::register(a, b));
    idle(Set::register(wheels, many, pair, Box::new(log.filter("boxed"))), 1);
    assert_eq!(log.take(), "left right x y z a b boxed");
}

#[test]
fn being_unregistered_takes_no_space() {
    assert_eq!(size_of::<Unregistered<[u8; 3]>>(), 3);
    assert_eq!(size_of::<OnlyInCeid<[u8; 3]>>(), 3);
}

#[test]
fn constructors_may_be_const() {
    const AXIS: Unregistered<[f64; 3]> = Unregistered::new([0.0; 3]);
    assert_eq!(AXIS.map(|axis| axis.len()).only_in_ceid().filter(), &3);
}

#[test]
fn the_migration_form_reaches_filters_made_for_it() {
    let log = Log::default();
    let mut kf = Unregistered::new(log.filter("kf")).only_in_ceid();
    let mut pf = log.filter("pf");
    let mut clock = Free::<Hz<10>>::new().take(2);
    while let Some(cycle) = clock.next_cycle() {
        ceid!(cycle => pf, kf);
        kf.read();
        pf.read();
        log.push("body");
    }
    kf.filter().read();
    assert_eq!(log.take(), "body pf kf body pf kf");
}

/// Registers of a chip, as a generator names them.
#[expect(non_upper_case_globals, non_camel_case_types, reason = "a generator writes them so")]
mod registers {
    pub(super) const control: u32 = 1;
    pub(super) const cycle: u32 = 2;
    pub(super) const parts: u32 = 4;
    pub(super) static rate: u32 = 8;
    pub(super) struct guard;
}

#[test]
fn what_the_macros_bind_has_names_of_its_own() {
    use registers::*;
    let log = Log::default();
    let (mut kf, mut pf) = (log.filter("kf"), log.filter("pf"));
    let mut clock = Free::<Hz<10>>::new().take(1);
    while let Some(now) = clock.next_cycle() {
        ceid!(now => kf);
        kf.read();
    }
    let mut clock = Free::<Hz<10>>::new().take(1);
    while let Some(now) = clock.next_cycle() {
        ceid!(now => kf, pf);
        kf.read();
        pf.read();
    }
    idle(Pair::register(log.filter("a"), log.filter("b")), 1);
    assert_eq!(log.take(), "kf kf pf a b");
    assert_eq!((size_of_val(&guard), control + cycle + parts + rate), (0, 15));
}

#[test]
fn the_migration_form_enters_a_set() {
    let log = Log::default();
    let mut robot = (Pair::register(log.filter("a"), log.filter("b")), 0);
    let mut clock = Free::<Hz<10>>::new().take(3);
    while let Some(cycle) = clock.next_cycle() {
        let n = cycle.info().n;
        ceid!(cycle => f = robot.0);
        robot.1 += 1;
        if n == 1 {
            continue;
        }
        let (a, b) = (&mut f.a, &mut f.b);
        a.read();
        b.read();
        log.push("body");
    }
    assert_eq!(log.take(), "body a b a b body a b");
    assert_eq!(robot.1, 3);
}

#[test]
fn a_shared_filter_is_registered_once_at_a_time() {
    let log = Log::default();
    let kf = Rc::new(Shared::new(log.filter("kf")));
    let first = Shared::try_register(Rc::clone(&kf));
    assert_eq!(Shared::try_register(&*kf).err(), Some(AlreadyRegistered));
    assert!(kf.is_registered());
    drop(first);
    assert!(!kf.is_registered());
    let again = Shared::try_register(Rc::clone(&kf)).expect("the first one is over");
    idle((again, log.filter("pf")), 2);
    assert_eq!(log.take(), "kf pf kf pf");
    assert!(!kf.is_registered(), "the set is gone");
}

#[test]
fn plug_ins_register_what_they_find() {
    let log = Log::default();
    let known: [Rc<Shared<dyn SampledFilter<Hz<10>>>>; 2] =
        [Rc::new(Shared::new(log.filter("kf"))), Rc::new(Shared::new(log.filter("pf")))];
    let wanted = [0, 1, 0, 0, 1];
    let set: Vec<_> = wanted.iter().filter_map(|&index| Shared::try_register(Rc::clone(&known[index])).ok()).collect();
    assert_eq!(set.len(), 2);
    idle(set, 2);
    assert_eq!(log.take(), "kf pf kf pf");
}

#[test]
fn a_shared_filter_is_not_updated_while_it_is_lent() {
    let log = Log::default();
    let kf = Shared::new(log.filter("kf"));
    let mut control = Cyclic::new(Shared::try_register(&kf).ok(), Free::<Hz<10>>::new());
    drop(control.cycle());
    assert_eq!(log.take(), "kf");
    assert!(catch_unwind(AssertUnwindSafe(|| kf.with(|_| drop(control.cycle())))).is_err(), "loudly, not silently");
    assert!(catch_unwind(AssertUnwindSafe(|| kf.with(|_| kf.with(|_| ())))).is_err());
    drop(control.cycle());
    assert_eq!(log.take(), "kf");
}

/// Writes down what it is given, and how old that is.
struct Reader {
    inbox: Sample<u32>,
    seen: Vec<(Option<u32>, Option<u32>)>,
}

impl<R: Rate> SampledFilter<R> for Reader {
    fn update(&mut self, tick: Tick<'_, R>) {
        let sample = self.inbox.take(&tick);
        self.seen.push((sample, self.inbox.age()));
    }
}

#[test]
fn a_measurement_counts_once() {
    let reader = Reader { inbox: Sample::new(), seen: Vec::new() };
    let mut control = Cyclic::new(reader, Free::<Hz<10>>::new().take(6));
    each_cycle!(f, info in control => {
        match info.n {
            1 => assert_eq!(f.inbox.put(10), None),
            4 => {
                assert_eq!(f.inbox.put(40), None);
                assert_eq!(f.inbox.put(41), Some(40), "the one that is lost is handed back");
            }
            _ => {}
        }
        assert_eq!(f.inbox.is_fresh(), info.n == 1 || info.n == 4);
    });
    assert_eq!(
        control.filters().seen,
        [(None, None), (Some(10), Some(0)), (None, Some(1)), (None, Some(2)), (Some(41), Some(0)), (None, Some(1))]
    );
}
