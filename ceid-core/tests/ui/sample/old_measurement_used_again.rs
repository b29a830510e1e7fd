//! E16: a measurement cannot be used in a cycle that has none.

use ceid_core::prelude::*;

struct KalmanF {
    position: Sample<f64>,
    estimate: f64,
}

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.estimate += tick.dt() * (self.position.take(&tick) - self.estimate);
    }
}

fn main() {}
