//! E1: an update law cannot be called by hand, as there is no tick to call it with.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

fn main() {
    let mut kf = KalmanF(0.0);
    loop {
        kf.update();
    }
}
