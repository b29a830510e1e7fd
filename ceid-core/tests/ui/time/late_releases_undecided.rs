//! E10: what becomes of late releases is a choice that has to be made.

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
    let _clock = Periodic::<Hz<1000>, _>::new(Timer);
    let _other = Periodic::<Hz<1000>, _>::new(Timer, Overrun::default());
}
