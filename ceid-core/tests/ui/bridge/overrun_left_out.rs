//! A task whose author has not thought of late cycles.

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
    let _motor = Task::new("motor", Motor);
}
