//! A filter that is built goes into a set.

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

filters! { struct Filters @ 1000 Hz { kf: KalmanF } }

fn main() {
    let mut filters = Filters::register(KalmanF::new());
    filters.kf.measure(2.0);
    assert_eq!(filters.kf.0, 2.0);
}
