//! Nanoseconds for one write and one read without contention. Each round runs all sides one after the other.

use crate::instructions::Value;
use crate::{Bar, heading, median, row};
use ceid_core::exchange::{Exchange, ExchangeCell, LatestCell, PriorityInheritingMutex, Read, Write};
use ceid_core::exchange::{Latest, LockApi, Locked, PriorityInheriting, StdMutex};
use std::hint::black_box;
use std::sync::Mutex;
use std::time::Instant;

const ROUNDS: usize = 41;
const COUNT: u32 = 100_000;

fn ns(mut operation: impl FnMut()) -> f64 {
    let begin = Instant::now();
    (0..COUNT).for_each(|_| operation());
    begin.elapsed().as_nanos() as f64 / f64::from(COUNT)
}

/// One round: write and read.
fn exchange<X: Exchange>() -> [f64; 2] {
    let mut cell = X::Cell::<Value>::new([0; 8]);
    let (mut writer, mut reader) = cell.split();
    let value = black_box([1; 8]);
    [ns(|| writer.set(*black_box(&value))), ns(|| _ = black_box(reader.get().value()))]
}

fn std_mutex() -> [f64; 2] {
    let mutex = Mutex::<Value>::new([0; 8]);
    let value = black_box([1; 8]);
    [
        ns(|| *mutex.lock().expect("not poisoned") = *black_box(&value)),
        ns(|| _ = black_box(*mutex.lock().expect("not poisoned"))),
    ]
}

fn triple_buffer_9() -> [f64; 2] {
    let (mut input, mut output) = triple_buffer::triple_buffer::<Value>(&[0; 8]);
    let value = black_box([1; 8]);
    [ns(|| input.write(*black_box(&value))), ns(|| _ = black_box(*output.read()))]
}

/// The value made accessible and not copied, which is what locks themselves cost.
fn in_place() -> [f64; 3] {
    let mut cell = LatestCell::<Value>::new([0; 8]);
    let (_, mut reader) = cell.split();
    let mutex = Mutex::<Value>::new([0; 8]);
    let inheriting = PriorityInheritingMutex::<Value>::new([0; 8]);
    [
        ns(|| _ = black_box(&*mutex.lock().expect("not poisoned"))),
        ns(|| _ = black_box(reader.read().value())),
        ns(|| inheriting.with(|value| _ = black_box(&*value))),
    ]
}

pub(crate) fn table() {
    heading(&format!(
        "nanoseconds per operation, 64 bytes, no contention (median of {ROUNDS} rounds, and of their ratios)"
    ));
    type Side = fn() -> [f64; 2];
    let sides: [(&str, Side); 6] = [
        ("std Mutex", std_mutex),
        ("triple_buffer 9", triple_buffer_9),
        ("Latest", exchange::<Latest>),
        ("Locked<StdMutex>", exchange::<Locked<StdMutex>>),
        ("Locked<LockApi<parking_lot>>", exchange::<Locked<LockApi<parking_lot::RawMutex>>>),
        ("Locked<PriorityInheriting>", exchange::<Locked<PriorityInheriting>>),
    ];
    let rounds: Vec<_> = (0..ROUNDS).map(|_| sides.map(|(_, side)| side())).collect();
    for (at, operation) in ["write", "read"].into_iter().enumerate() {
        let compare = |side: usize, other: usize, bar| {
            let median_of = |side: usize| median(rounds.iter().map(|round| round[side][at]).collect());
            let ratio = median(rounds.iter().map(|round| round[side][at] / round[other][at]).collect());
            let what = format!("{operation}: {} / {}", sides[side].0, sides[other].0);
            row(&what, &format!("{:.2} / {:.2} ns", median_of(side), median_of(other)), ratio, bar);
        };
        compare(2, 0, if operation == "read" { Bar::AtMost(0.10) } else { Bar::None });
        compare(2, 1, Bar::AtMost(1.10));
        compare(3, 0, Bar::None);
        compare(4, 0, Bar::None);
        compare(5, 0, if operation == "write" { Bar::AtMost(1.15) } else { Bar::None });
    }
    let rounds: Vec<_> = (0..ROUNDS).map(|_| in_place()).collect();
    for (side, name, most) in [(1, "Latest", 0.10), (2, "PriorityInheritingMutex", 1.15)] {
        let median_of = |side: usize| median(rounds.iter().map(|round| round[side]).collect());
        let ratio = median(rounds.iter().map(|round| round[side] / round[0]).collect());
        let figures = format!("{:.2} / {:.2} ns", median_of(side), median_of(0));
        row(&format!("read in place: {name} / std Mutex"), &figures, ratio, Bar::AtMost(most));
    }
}
