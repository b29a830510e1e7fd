//! A filter that is built and registered.

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
    let mut control = Cyclic::new(Filters::register(kf), Free::<Hz<1000>>::new().take(3));
    each_cycle!(f in control => { f.kf.estimate += 0.0 });
    assert_eq!(control.filters().kf.estimate, 0.003);
}
