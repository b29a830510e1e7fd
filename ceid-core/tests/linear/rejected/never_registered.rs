//! E4: a filter that is built and then forgotten.

use ceid_core::prelude::*;

struct KalmanF {
    estimate: f64,
}

impl KalmanF {
    fn new(estimate: f64) -> Unregistered<Self> {
        Unregistered::new(Self { estimate })
    }
}

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.estimate += tick.dt();
    }
}

fn main() {
    let _kf = KalmanF::new(0.0);
}
