//! E4: an early return drops the filter that is not registered yet.

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

filters! { struct Filters @ 1000 Hz { kf: KalmanF } }

fn filters(text: &str) -> Option<Filters> {
    let kf = KalmanF::new(0.0);
    let offset: f64 = text.parse().ok()?;
    let mut filters = Filters::register(kf);
    filters.kf.estimate = offset;
    Some(filters)
}

fn main() {
    assert!(filters("1.5").is_some());
}
