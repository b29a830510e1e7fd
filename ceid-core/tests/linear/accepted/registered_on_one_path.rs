//! Both branches register the filter.

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

fn main() {
    let kf = KalmanF::new(0.0);
    let filters = if std::env::args().count() == 1 {
        Filters::register(kf)
    } else {
        Filters::register(kf.map(|kf| KalmanF { estimate: kf.estimate + 1.0 }))
    };
    assert_eq!(filters.kf.estimate, 0.0);
}
