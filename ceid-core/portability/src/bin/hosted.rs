//! The demo on an operating system. Its output is what the other targets' is compared with.

use ceid_core::Time;
use std::fmt;
use std::thread;
use std::time::{Duration, Instant};

#[path = "../demo.rs"]
mod demo;
#[path = "../../../examples/subsumption/robot/mod.rs"]
#[allow(dead_code, reason = "the example uses all of it")]
mod robot;
#[path = "../robot_paths.rs"]
mod robot_paths;

struct Clock(Instant);

impl Time for Clock {
    fn now_ns(&mut self) -> u64 {
        self.0.elapsed().as_nanos() as u64
    }

    fn sleep_until_ns(&mut self, at_ns: u64) {
        thread::sleep(Duration::from_nanos(at_ns.saturating_sub(self.now_ns())));
    }
}

fn main() -> fmt::Result {
    let mut output = demo::report(Clock(Instant::now())).to_string();
    robot_paths::print::<11>(&mut output, 1)?;
    robot_paths::print::<71>(&mut output, 7)?;
    print!("{output}");
    Ok(())
}
