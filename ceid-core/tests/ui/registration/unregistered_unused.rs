//! E4: with the lints of the README, a filter that is built and dropped at once does not compile.

#![deny(unused_must_use)]

use ceid_core::prelude::*;

struct KalmanF(f64);

impl KalmanF {
    fn new() -> Unregistered<Self> {
        Unregistered::new(Self(0.0))
    }

    fn measure(&mut self, position: f64) {
        self.0 = position;
    }
}

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

fn main() {
    KalmanF::new();
}
