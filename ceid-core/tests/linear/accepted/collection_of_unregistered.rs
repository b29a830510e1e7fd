//! Collections are built around the filters, and registered as one.

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

filters! { struct Filters @ 1000 Hz { three: [KalmanF; 3]; many: Vec<KalmanF>; pair: (KalmanF, KalmanF) } }

fn main() {
    let three = Unregistered::array(|index| KalmanF::new(index as f64));
    let many = (0..5).map(|n| KalmanF::new(f64::from(n))).collect::<Unregistered<Vec<_>>>();
    let pair = KalmanF::new(7.0).zip(KalmanF::new(8.0));
    let filters = Filters::register(three, many, pair);
    assert_eq!((filters.three[2].estimate, filters.many[4].estimate, filters.pair.1.estimate), (2.0, 4.0, 8.0));
}
