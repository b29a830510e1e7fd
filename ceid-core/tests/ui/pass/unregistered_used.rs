//! A filter is registered, and then used.

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
    let kf = KalmanF::new();
    let mut control = Cyclic::new(Filters::register(kf), Free::<Hz<1000>>::new().take(3));
    each_cycle!(f in control => {
        f.kf.measure(1.0);
    });
    assert_eq!(control.filters().kf.0, 1.001);
}
