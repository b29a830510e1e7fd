//! Instructions for one write, one read and both, counted by valgrind: exact, whatever else the machine does.

use crate::{Bar, heading, row, tool};
use ceid_core::exchange::LatestCell;
use std::hint::black_box;
use std::sync::Mutex;

pub(crate) type Value = [u64; 8];

/// Runs one operation `count` times, under valgrind. A function each, so that the compiler treats all alike.
pub(crate) fn run(what: &str, count: u64) {
    match what {
        "latest-write" => latest_write(count),
        "latest-read" => latest_read(count),
        "latest-both" => latest_both(count),
        "triple-write" => triple_write(count),
        "triple-read" => triple_read(count),
        "triple-both" => triple_both(count),
        "mutex-write" => mutex_write(count),
        "mutex-read" => mutex_read(count),
        "mutex-both" => mutex_both(count),
        _ => panic!("no operation is called {what}"),
    }
}

#[inline(never)]
fn latest_write(count: u64) {
    let mut cell = LatestCell::<Value>::new([0; 8]);
    let (mut writer, _reader) = cell.split();
    let value = black_box([1; 8]);
    for _ in 0..count {
        writer.set(*black_box(&value));
    }
}

#[inline(never)]
fn latest_read(count: u64) {
    let mut cell = LatestCell::<Value>::new([0; 8]);
    let (_writer, mut reader) = cell.split();
    for _ in 0..count {
        black_box(*reader.read().value());
    }
}

#[inline(never)]
fn latest_both(count: u64) {
    let mut cell = LatestCell::<Value>::new([0; 8]);
    let (mut writer, mut reader) = cell.split();
    let value = black_box([1; 8]);
    for _ in 0..count {
        writer.set(*black_box(&value));
        black_box(*reader.read().value());
    }
}

#[inline(never)]
fn triple_write(count: u64) {
    let (mut input, _output) = triple_buffer::triple_buffer::<Value>(&[0; 8]);
    let value = black_box([1; 8]);
    for _ in 0..count {
        input.write(*black_box(&value));
    }
}

#[inline(never)]
fn triple_read(count: u64) {
    let (_input, mut output) = triple_buffer::triple_buffer::<Value>(&[0; 8]);
    for _ in 0..count {
        black_box(*output.read());
    }
}

#[inline(never)]
fn triple_both(count: u64) {
    let (mut input, mut output) = triple_buffer::triple_buffer::<Value>(&[0; 8]);
    let value = black_box([1; 8]);
    for _ in 0..count {
        input.write(*black_box(&value));
        black_box(*output.read());
    }
}

#[inline(never)]
fn mutex_write(count: u64) {
    let mutex = Mutex::<Value>::new([0; 8]);
    let value = black_box([1; 8]);
    for _ in 0..count {
        *mutex.lock().expect("not poisoned") = *black_box(&value);
    }
}

#[inline(never)]
fn mutex_read(count: u64) {
    let mutex = Mutex::<Value>::new([0; 8]);
    for _ in 0..count {
        black_box(*mutex.lock().expect("not poisoned"));
    }
}

#[inline(never)]
fn mutex_both(count: u64) {
    let mutex = Mutex::<Value>::new([0; 8]);
    let value = black_box([1; 8]);
    for _ in 0..count {
        *mutex.lock().expect("not poisoned") = *black_box(&value);
        black_box(*mutex.lock().expect("not poisoned"));
    }
}

pub(crate) fn table() {
    heading("instructions per operation, 64 bytes (valgrind)");
    for (key, operation) in [("write", "write"), ("read", "read"), ("both", "write and read")] {
        let count = |kind: &str| per_operation(&format!("{kind}-{key}"));
        let (Some(latest), Some(triple), Some(mutex)) = (count("latest"), count("triple"), count("mutex")) else {
            return;
        };
        let against = |name: &str, other: f64, bar| {
            row(
                &format!("instructions to {operation}: `Latest` / {name}"),
                &format!("{latest:.2} / {other:.2}"),
                latest / other,
                bar,
            );
        };
        against("`triple_buffer` 9", triple, Bar::AtMost(1.0));
        against("std `Mutex`", mutex, Bar::None);
    }
}

/// The difference of two runs, so that starting and ending the program does not count.
fn per_operation(what: &str) -> Option<f64> {
    const COUNT: u64 = 100_000;
    let total = |count: u64| {
        let program = std::env::current_exe().expect("a program knows its own path");
        let arguments = ["--tool=callgrind", "--callgrind-out-file=/dev/null"];
        let program = [program.to_str().expect("the path is UTF-8"), "instructions", what, &count.to_string()];
        let output = tool("valgrind", "valgrind", &[&arguments[..], &program[..]].concat())?;
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        let collected = text.lines().find_map(|line| line.split_once("Collected : "))?.1.trim();
        collected.parse::<u64>().ok()
    };
    Some((total(2 * COUNT)? - total(COUNT)?) as f64 / COUNT as f64)
}
