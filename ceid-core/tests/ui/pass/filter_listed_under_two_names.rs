//! Two fields are listed under two names.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

struct Robot {
    kf: KalmanF,
    pf: KalmanF,
}

fn control(robot: &mut Robot) {
    let mut clock = Free::<Hz<1000>>::new().take(1);
    while let Some(cycle) = clock.next_cycle() {
        ceid!(cycle => a = robot.kf, b = robot.pf);
        a.0 = b.0;
    }
}

fn main() {
    control(&mut Robot { kf: KalmanF(0.0), pf: KalmanF(0.0) });
}
