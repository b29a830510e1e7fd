//! E3: the same field cannot be listed under two names.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

struct Robot {
    kf: KalmanF,
}

fn control(robot: &mut Robot) {
    let mut clock = Free::<Hz<1000>>::new();
    while let Some(cycle) = clock.next_cycle() {
        ceid!(cycle => a = robot.kf, b = robot.kf);
        a.0 = b.0;
    }
}

fn main() {
    control(&mut Robot { kf: KalmanF(0.0) });
}
