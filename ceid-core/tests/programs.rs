//! Random bodies: whatever way out each cycle takes, each filter is updated once in each cycle that was entered, and in
//! the order of registration. All forms of the guard run the same programs.

#![cfg(feature = "alloc")]

use ceid_core::prelude::*;
use core::ops::ControlFlow::{Break, Continue};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

mod common;
use common::random::Random;
use common::{Log, Logged};

/// What the body of one cycle does.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Way {
    End,
    Continue,
    ContinueFromInnerLoop,
    LeaveBlock,
    Break,
    BreakFromInnerLoop,
    Return,
    QuestionMark,
    Panic,
}

impl Way {
    fn ends_the_loop(self) -> bool {
        matches!(self, Self::Break | Self::BreakFromInnerLoop | Self::Return | Self::QuestionMark | Self::Panic)
    }
}

const WAYS: [Way; 9] = [
    Way::End,
    Way::Continue,
    Way::ContinueFromInnerLoop,
    Way::LeaveBlock,
    Way::Break,
    Way::BreakFromInnerLoop,
    Way::Return,
    Way::QuestionMark,
    Way::Panic,
];

type Cycles = ceid_core::Take<Free<Hz<1000>>>;

filters! { struct Set @ 1000 Hz { first: Logged; several: Vec<Logged>; last: Option<Logged> } }

const NAMES: [&str; 6] = ["a", "b", "c", "d", "e", "f"];

/// A set of one to eight filters, and its names in order.
fn set(log: &Log, random: &mut Random) -> (Set, Vec<&'static str>) {
    let several = &NAMES[..random.below(7) as usize];
    let last = (random.below(2) == 0).then_some("last");
    let names = std::iter::once("first").chain(several.iter().copied()).chain(last).collect();
    let set = Set::register(
        log.filter("first"),
        several.iter().map(|name| log.filter(name)).collect::<Vec<_>>(),
        last.map(|name| log.filter(name)),
    );
    (set, names)
}

/// The body, the same for all forms that have natural control flow.
macro_rules! body {
    ($ways:ident, $n:expr, $log:ident, $filter:expr, $label:lifetime) => {
        $filter.read();
        match $ways[$n as usize] {
            Way::End => {}
            Way::Continue => continue,
            Way::ContinueFromInnerLoop => {
                for _ in 0..3 {
                    continue $label;
                }
            }
            Way::LeaveBlock => 'block: {
                if $filter.name == "first" {
                    break 'block;
                }
                $log.push("unreachable");
            }
            Way::Break => break,
            Way::BreakFromInnerLoop => loop {
                break $label;
            },
            Way::Return => return Some(()),
            Way::QuestionMark => None?,
            Way::Panic => resume_unwind(Box::new("sensor")),
        }
        $log.push("body");
    };
}

fn each_cycle_form(set: Set, clock: Cycles, ways: &[Way], log: &Log) -> Option<()> {
    let mut control = Cyclic::new(set, clock);
    // No label can stand before the macro, so `continue 'again` begins a new loop of the same driver.
    'again: while control.clock().clone().wait().is_some() {
        each_cycle!(f, info in control => {
            body!(ways, info.n, log, f.first, 'again);
        });
        break;
    }
    None
}

fn named_form(set: Set, clock: Cycles, ways: &[Way], log: &Log) -> Option<()> {
    let mut control = Cyclic::new(set, clock);
    'cycles: while let Some(mut guard) = control.cycle() {
        let n = guard.info().n;
        let f = guard.filters();
        body!(ways, n, log, f.first, 'cycles);
    }
    None
}

fn list_form(set: Set, mut clock: Cycles, ways: &[Way], log: &Log) -> Option<()> {
    let Set { mut first, mut several, mut last, .. } = set;
    'cycles: while let Some(cycle) = clock.next_cycle() {
        let n = cycle.info().n;
        ceid!(cycle => first, several, last);
        body!(ways, n, log, first, 'cycles);
    }
    None
}

fn list_form_with_a_set(mut set: Set, mut clock: Cycles, ways: &[Way], log: &Log) -> Option<()> {
    'cycles: while let Some(cycle) = clock.next_cycle() {
        let n = cycle.info().n;
        ceid!(cycle => f = set);
        body!(ways, n, log, f.first, 'cycles);
    }
    None
}

fn closure_form(set: Set, clock: Cycles, ways: &[Way], log: &Log) -> Option<()> {
    Cyclic::new(set, clock).run(|f, info| {
        f.first.read();
        match ways[info.n as usize] {
            Way::End | Way::LeaveBlock => {}
            Way::Continue | Way::ContinueFromInnerLoop => return Continue(()),
            Way::Panic => resume_unwind(Box::new("sensor")),
            _ => return Break(()),
        }
        log.push("body");
        Continue(())
    })
}

type Form = fn(Set, Cycles, &[Way], &Log) -> Option<()>;

#[test]
fn each_filter_is_updated_once_in_each_entered_cycle() {
    let forms: [(&str, Form); 5] = [
        ("each_cycle!", each_cycle_form),
        ("cycle()", named_form),
        ("ceid!", list_form),
        ("ceid! with a set", list_form_with_a_set),
        ("run", closure_form),
    ];
    let mut random = Random::new(2019);
    let mut ways_out = 0;
    for program in 0..500 {
        // Mostly ways that go on, so that programs are several cycles long.
        let ways: Vec<_> = (0..8)
            .map(|_| {
                let choices = if random.below(4) == 0 { WAYS.len() } else { 4 };
                WAYS[random.below(choices as u64) as usize]
            })
            .collect();
        ways_out += usize::from(ways.iter().any(|way| way.ends_the_loop()));
        let seed = random.next();
        for (name, form) in forms {
            let log = Log::default();
            let (set, filters) = set(&log, &mut Random::new(seed));
            let mut expected = Vec::new();
            for way in &ways {
                if matches!(way, Way::End | Way::LeaveBlock) {
                    expected.push("body");
                }
                expected.extend(&filters);
                if way.ends_the_loop() {
                    break;
                }
            }
            let clock = Free::<Hz<1000>>::new().take(ways.len() as u64);
            let panicked = catch_unwind(AssertUnwindSafe(|| form(set, clock, &ways, &log))).is_err();
            assert_eq!(log.take(), expected.join(" "), "program {program} in the form {name}: {ways:?}");
            assert_eq!(panicked, ways.iter().find(|way| way.ends_the_loop()) == Some(&Way::Panic));
        }
    }
    assert!(ways_out > 100, "the programs leave their loops: {ways_out}");
}
