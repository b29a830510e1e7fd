//! How late a cycle of 1 ms begins: real-time threads against `cyclictest`, ordinary threads against a plain sleep. Each
//! side is a process of its own; the sides take turns.

use crate::{Bar, heading, median, row, this_program, tool};
use ceid_core::prelude::*;
use ceid_core::thread::{ChronoCycleThread, Histogram, IfRefused, RtPreemptCycleThread, Scheduling, Task, Until};
use std::hint::black_box;
use std::process::Child;
use std::time::{Duration, Instant};

const ROUNDS: usize = 5;
const SECONDS: u64 = 5;
const BUCKETS: usize = 10_000;

struct Nothing;

impl RealtimeFunctionality for Nothing {
    type Rate = Hz<1000>;

    fn cycle(&mut self, _: CycleInfo) -> Flow {
        Flow::Continue
    }
}

/// Runs in one world, and prints how late cycles began, as `cyclictest -h` does: microseconds and how often.
pub(crate) fn run(world: &str, seconds: u64) {
    let until = Until::duration(Duration::from_secs(seconds));
    let mut task = Task::new("task", Nothing, Overrun::Skip).with_histogram::<BUCKETS>(1_000);
    match world {
        "rt-preempt" => {
            let mut thread = RtPreemptCycleThread::new(Scheduling::Fifo { priority: 80 }, IfRefused::DoNotRun);
            let privileges = thread.run(&mut [&mut task], until);
            eprint!("{privileges}");
        }
        "chrono" => {
            let privileges = ChronoCycleThread::new().run(&mut [&mut task], until);
            eprint!("{privileges}");
        }
        "sleep" => return print(&plain_sleep(seconds)),
        _ => panic!("no world is called {world}"),
    }
    print(task.lateness());
}

/// What one writes without a library.
fn plain_sleep(seconds: u64) -> Histogram<BUCKETS> {
    let mut late = Histogram::with_width_ns(1_000);
    let begin = Instant::now();
    for n in 0..seconds * 1000 {
        let release = begin + Duration::from_millis(n);
        std::thread::sleep(release.saturating_duration_since(Instant::now()));
        late.record(release.elapsed().as_nanos() as u64);
    }
    late
}

fn print(late: &Histogram<BUCKETS>) {
    for (us, count) in late.buckets().iter().enumerate().filter(|(_, count)| **count > 0) {
        println!("{us} {count}");
    }
    println!("{BUCKETS} {}", late.beyond());
}

pub(crate) fn hog(seconds: u64) {
    let begin = Instant::now();
    while begin.elapsed() < Duration::from_secs(seconds) {
        black_box(begin);
    }
}

/// The median and the 99th percentile of lines of microseconds and how often.
fn percentiles(text: &str) -> Option<[f64; 2]> {
    let buckets: Vec<(f64, u64)> = text
        .lines()
        .filter(|line| !line.starts_with('#'))
        .filter_map(|line| {
            let (us, count) = line.split_once(char::is_whitespace)?;
            Some((us.parse().ok()?, count.trim().parse().ok()?))
        })
        .collect();
    let total: u64 = buckets.iter().map(|(_, count)| count).sum();
    let at = |share: f64| {
        let mut seen = 0;
        buckets.iter().find_map(|(us, count)| {
            seen += count;
            (seen as f64 >= share * total as f64).then_some(*us)
        })
    };
    (total > 0).then(|| Some([at(0.5)?, at(0.99)?]))?
}

fn measure(side: &str) -> Option<[f64; 2]> {
    let output = if side == "cyclictest" {
        let loops = (SECONDS * 1000).to_string();
        tool("cyclictest", "rt-tests", &["-m", "-p80", "-i1000", "-l", &loops, "-q", "-h", "10000"])?
    } else {
        this_program().args(["wake-up", side, &SECONDS.to_string()]).output().ok()?
    };
    let found = percentiles(&String::from_utf8_lossy(&output.stdout));
    if found.is_none() {
        println!("  {side} did not run: {}", String::from_utf8_lossy(&output.stderr));
    }
    found
}

pub(crate) fn table() {
    for (load, hogs) in [("idle", 0), ("a busy process for each processor", 2)] {
        heading(&format!("wake-up at 1 kHz, {load} (median of {ROUNDS} alternations of {SECONDS} s)"));
        let sides = [
            ("rt-preempt", "`RtPreemptCycleThread`"),
            ("cyclictest", "`cyclictest`"),
            ("chrono", "`ChronoCycleThread`"),
            ("sleep", "`thread::sleep`"),
        ];
        let rounds: Vec<_> = (0..ROUNDS).map(|_| sides.map(|(side, _)| with_load(hogs, || measure(side)))).collect();
        for (name, at) in [("p50", 0), ("p99", 1)] {
            let compare = |side: usize, other: usize, most: f64| {
                let values =
                    |side: usize| rounds.iter().map(|round| round[side].map(|it| it[at])).collect::<Option<Vec<_>>>();
                let (Some(one), Some(two)) = (values(side), values(other)) else { return };
                // The machine drifts between rounds, so that only the sides of one round are compared.
                let ratio = median(one.iter().zip(&two).map(|(one, two)| one / two).collect());
                let (one, two) = (median(one), median(two));
                let bar = if name == "p50" { Bar::AtMost(most) } else { Bar::None };
                row(
                    &format!("wake-up {name}, {load}: {} / {}", sides[side].1, sides[other].1),
                    &format!("{one} / {two} µs"),
                    ratio,
                    bar,
                );
            };
            compare(0, 1, 1.25);
            compare(2, 3, 0.5);
        }
    }
}

fn with_load<T>(hogs: u32, work: impl FnOnce() -> T) -> T {
    let seconds = (SECONDS + 5).to_string();
    let hogs: Vec<Child> = (0..hogs).filter_map(|_| this_program().args(["hog", &seconds]).spawn().ok()).collect();
    let result = work();
    for mut hog in hogs {
        // It may have ended by itself.
        let _ = hog.kill();
        let _ = hog.wait();
    }
    result
}
