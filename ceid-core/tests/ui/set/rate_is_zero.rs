//! E10: a set cannot run at 0 Hz.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

filters! { struct Filters @ 0 Hz { kf: KalmanF } }

fn main() {}
