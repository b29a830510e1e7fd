//! The triple buffer in every order of its atomic steps, as loom finds them. The file that is modelled is the file that
//! ships: it is compiled here against loom's atomics.
//!
//! The default tests take a second. More writes, reads and preemptions, in a quarter of a minute:
//!
//! ```text
//! cargo test --release -p ceid-core --test loom -- --ignored
//! ```

#[path = "../../src/exchange/latest.rs"]
#[allow(dead_code, unreachable_pub, clippy::allow_attributes, reason = "compiled as a part of another crate")]
mod latest;
mod sync;

use ceid_core::exchange::Reading;
use latest::{LatestCell, LatestReader, LatestWriter};
use sync::Bug;

/// Two halves that have to arrive together.
type Value = [usize; 2];

type Ends = (LatestWriter<'static, Value>, LatestReader<'static, Value>);

/// A cell for one execution of a model, which is as long as a program for it.
fn cell() -> &'static mut LatestCell<Value> {
    Box::leak(Box::new(LatestCell::new([0, 0])))
}

fn write(writer: &mut LatestWriter<'_, Value>, n: usize) {
    writer.set([n, n]);
}

/// Reads, and checks what a reader may rely on: whole values, in order, and a stale one is the one it had.
fn read(reader: &mut LatestReader<'_, Value>, last: &mut usize) {
    match reader.read() {
        Reading::Fresh([one, other]) => {
            assert_eq!(one, other, "torn");
            assert!(one > last, "{one} after {last}");
            *last = *one;
        }
        Reading::Stale([one, other]) => assert_eq!((one, other), (&*last, &*last), "changed, and called stale"),
    }
}

fn check(bug: Bug, preemptions: usize, model: impl Fn() + Send + Sync + 'static) {
    let mut builder = loom::model::Builder::new();
    builder.preemption_bound = Some(preemptions);
    builder.check(move || {
        sync::seed(bug);
        model();
    });
}

/// One thread writes, one reads; at the end the reader has the last value.
fn one_way(writes: usize, reads: usize) {
    let (mut writer, mut reader): Ends = cell().split();
    let thread = loom::thread::spawn(move || (1..=writes).for_each(|n| write(&mut writer, n)));
    let mut last = 0;
    (0..reads).for_each(|_| read(&mut reader, &mut last));
    thread.join().expect("the writer does not panic");
    read(&mut reader, &mut last);
    assert_eq!(last, writes, "the last value has not arrived");
}

#[test]
fn values_arrive_whole_in_order_and_at_last() {
    check(Bug::None, 4, || one_way(4, 4));
}

#[test]
#[ignore = "takes a minute in a debug build: see the head of this file"]
fn values_arrive_whole_in_order_and_at_last_over_many_writes() {
    check(Bug::None, 7, || one_way(6, 6));
}

/// Two cells, one for each direction, as in a `TransactionIo`.
fn both_directions(rounds: usize) {
    let (mut set_input, mut input): Ends = cell().split();
    let (mut set_output, mut output): Ends = cell().split();
    let inside = loom::thread::spawn(move || {
        let mut last = 0;
        for n in 1..=rounds {
            read(&mut input, &mut last);
            write(&mut set_output, n);
        }
        read(&mut input, &mut last);
    });
    let mut last = 0;
    for n in 1..=rounds {
        write(&mut set_input, n);
        read(&mut output, &mut last);
    }
    inside.join().expect("the inside does not panic");
    read(&mut output, &mut last);
    assert_eq!(last, rounds, "the last output has not arrived");
}

#[test]
fn a_transaction_hands_over_in_both_directions() {
    check(Bug::None, 3, || both_directions(2));
}

#[test]
#[ignore = "takes a minute in a debug build: see the head of this file"]
fn a_transaction_hands_over_in_both_directions_over_many_rounds() {
    check(Bug::None, 4, || both_directions(3));
}

/// The ends change threads and are taken anew; the next ones go on where the last ones stopped.
fn split_again() {
    let cell = std::ptr::from_mut(cell());
    let mut last = 0;
    for round in [1, 3] {
        // SAFETY: the ends of the round before are gone: one was dropped here, one in the thread that was joined.
        let (mut writer, mut reader): Ends = unsafe { &mut *cell }.split();
        let thread = loom::thread::spawn(move || (round..round + 2).for_each(|n| write(&mut writer, n)));
        (0..2).for_each(|_| read(&mut reader, &mut last));
        thread.join().expect("the writer does not panic");
    }
    // SAFETY: as above.
    let (_, mut reader): Ends = unsafe { &mut *cell }.split();
    read(&mut reader, &mut last);
    assert_eq!(last, 4, "the last value has not arrived");
}

#[test]
fn new_ends_go_on_where_the_last_ones_stopped() {
    check(Bug::None, 3, split_again);
}

#[test]
fn only_one_of_two_threads_gets_the_ends() {
    check(Bug::None, 3, || {
        let cell: &'static LatestCell<Value> = cell();
        let thread = loom::thread::spawn(|| cell.split_once().is_some());
        let here = cell.split_once().is_some();
        assert_ne!(thread.join().expect("it does not panic"), here);
    });
}

// The bugs below are the proof that the models look: each of them has to be found.

#[test]
#[should_panic(expected = "Causality violation")]
fn a_relaxed_swap_is_found() {
    check(Bug::Relaxed, 3, || one_way(3, 3));
}

#[test]
#[should_panic(expected = "Causality violation")]
fn a_swap_without_release_is_found() {
    check(Bug::AcquireOnly, 3, || one_way(3, 3));
}

#[test]
#[should_panic(expected = "Causality violation")]
fn a_swap_without_acquire_is_found() {
    check(Bug::ReleaseOnly, 3, || one_way(3, 3));
}

#[test]
#[should_panic(expected = "the last value has not arrived")]
fn a_swap_in_two_steps_is_found() {
    check(Bug::NotAtomic, 4, || one_way(3, 3));
}
