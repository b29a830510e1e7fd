//! What is fed to the adapter is what the guard updates the filter with, once at the end of the cycle.

use ceid_core::prelude::*;

struct Pid {
    sum: f64,
}

impl Pid {
    fn step(&mut self, error: f64) -> f64 {
        self.sum += error;
        0.5 * self.sum
    }
}

fn main() {
    let mut pid = Pid { sum: 0.0 };
    let mut clock = Free::<Hz<1000>>::new().take(3);
    let mut fed_pid = Adapted::fed(&mut pid, |pid, error| pid.step(error));
    while let Some(cycle) = clock.next_cycle() {
        ceid!(cycle => control = fed_pid);
        control.feed(2.0);
        control.feed(4.0);
    }
    assert_eq!(pid.sum, 12.0);
}
