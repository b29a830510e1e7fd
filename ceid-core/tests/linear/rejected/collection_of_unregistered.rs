//! E4: a collection could be dropped before its filters are registered.

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
    let kfs: Vec<Unregistered<KalmanF>> = (0..3).map(|n| KalmanF::new(f64::from(n))).collect();
    std::process::exit(if kfs.len() == 3 { 0 } else { 1 });
}
