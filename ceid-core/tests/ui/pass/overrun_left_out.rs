//! What becomes of late cycles is said.

use ceid_core::prelude::*;
use ceid_core::thread::Task;

struct Motor;

impl RealtimeFunctionality for Motor {
    type Rate = Hz<1000>;

    fn cycle(&mut self, _: CycleInfo) -> Flow {
        Flow::Stop
    }
}

fn main() {
    let motor = Task::new("motor", Motor, Overrun::Skip);
    assert_eq!(motor.cycles(), 0);
}
