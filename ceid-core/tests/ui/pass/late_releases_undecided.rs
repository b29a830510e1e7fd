//! The choice is made.

use ceid_core::Time;
use ceid_core::prelude::*;

struct Timer;

impl Time for Timer {
    fn now_ns(&mut self) -> u64 {
        0
    }

    fn sleep_until_ns(&mut self, _: u64) {}
}

fn main() {
    let mut clock = Periodic::<Hz<1000>, _>::new(Timer, Overrun::CatchUp { max: 2 });
    assert!(clock.wait().is_some());
}
