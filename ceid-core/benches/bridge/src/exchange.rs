//! Nanoseconds for one write and one read without contention. Each round runs all sides one after the other.

use crate::instructions::Value;
use crate::{Bar, heading, row};
use ceid_core::exchange::{Exchange, ExchangeCell, LatestCell, PriorityInheritingMutex, Read, Write};
use ceid_core::exchange::{Latest, LockApi, Locked, PriorityInheriting, StdMutex};
use std::hint::black_box;
use std::sync::Mutex;
use std::time::Instant;

/// Many short rounds, because another program that runs on the same core makes an operation of one clock cycle twice as long.
const ROUNDS: usize = 1_001;
const COUNT: u32 = 10_000;

/// Eight operations in each iteration: the shortest take as long as the jump of a loop, and how long that takes depends on
/// where the compiler happens to put it.
fn ns(mut operation: impl FnMut()) -> f64 {
    const UNROLLED: u32 = 8;
    let begin = Instant::now();
    for _ in 0..COUNT / UNROLLED {
        operation();
        operation();
        operation();
        operation();
        operation();
        operation();
        operation();
        operation();
    }
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

/// The value made accessible and not copied, which is what the exchanges themselves cost; and the copy alone.
fn in_place() -> [f64; 4] {
    let mut cell = LatestCell::<Value>::new([0; 8]);
    let (_, mut reader) = cell.split();
    let mutex = Mutex::<Value>::new([0; 8]);
    let inheriting = PriorityInheritingMutex::<Value>::new([0; 8]);
    let value = [1; 8];
    [
        ns(|| _ = black_box(&*mutex.lock().expect("not poisoned"))),
        ns(|| _ = black_box(reader.read().value())),
        ns(|| inheriting.with(|value| _ = black_box(&*value))),
        ns(|| _ = black_box(*black_box(&value))),
    ]
}

/// The shortest time of each side and operation: what it takes when no other program is in the way.
fn fastest<const SIDES: usize, const OPERATIONS: usize>(
    sides: [fn() -> [f64; OPERATIONS]; SIDES],
) -> [[f64; OPERATIONS]; SIDES] {
    let mut fastest = [[f64::INFINITY; OPERATIONS]; SIDES];
    for _ in 0..ROUNDS {
        for (fastest, side) in fastest.iter_mut().zip(sides) {
            fastest.iter_mut().zip(side()).for_each(|(fastest, ns)| *fastest = fastest.min(ns));
        }
    }
    fastest
}

pub(crate) fn table() {
    heading(&format!("nanoseconds per operation, 64 bytes, no contention (shortest of {ROUNDS} rounds)"));
    let compare = |what: &str, one: f64, other: f64, bar| {
        row(what, &format!("{one:.2} / {other:.2} ns"), one / other, bar);
    };
    let [mutex, triple, latest, std, parking_lot, inheriting] = fastest([
        std_mutex,
        triple_buffer_9,
        exchange::<Latest>,
        exchange::<Locked<StdMutex>>,
        exchange::<Locked<LockApi<parking_lot::RawMutex>>>,
        exchange::<Locked<PriorityInheriting>>,
    ]);
    for (at, operation) in ["write", "read and copied"].into_iter().enumerate() {
        let compare = |names: &str, one: [f64; 2], other: [f64; 2], bar| {
            compare(&format!("{operation}: {names}"), one[at], other[at], bar);
        };
        compare("`Latest` / std `Mutex`", latest, mutex, Bar::None);
        compare("`Latest` / `triple_buffer` 9", latest, triple, Bar::AtMost(1.10));
        compare("`Locked<StdMutex>` / std `Mutex`", std, mutex, Bar::None);
        compare("`Locked<LockApi<parking_lot>>` / std `Mutex`", parking_lot, mutex, Bar::None);
        compare("`Locked<PriorityInheriting>` / std `Mutex`", inheriting, mutex, Bar::None);
    }
    let [[mutex, latest, inheriting, copy]] = fastest([in_place]);
    compare("the copy alone / read in place: std `Mutex`", copy, mutex, Bar::None);
    compare("read in place: `Latest` / std `Mutex`", latest, mutex, Bar::AtMost(0.10));
    compare("read in place: `PriorityInheritingMutex` / std `Mutex`", inheriting, mutex, Bar::AtMost(1.15));
}
