//! The demo on an operating system. Its output is what the other targets' is compared with.

use ceid_core::Time;
use std::thread;
use std::time::{Duration, Instant};

#[path = "../demo.rs"]
mod demo;

struct Clock(Instant);

impl Time for Clock {
    fn now_ns(&mut self) -> u64 {
        self.0.elapsed().as_nanos() as u64
    }

    fn sleep_until_ns(&mut self, at_ns: u64) {
        thread::sleep(Duration::from_nanos(at_ns.saturating_sub(self.now_ns())));
    }
}

fn main() {
    print!("{}", demo::report(Clock(Instant::now())));
}
