//! A driver may be run again after its loop.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

filters! { struct Filters @ 1000 Hz { kf: KalmanF; pf: KalmanF } }

fn main() {
    let mut control = Cyclic::new(Filters::register(KalmanF(0.0), KalmanF(0.0)), Free::<Hz<1000>>::new().take(3));
    each_cycle!(f in control => {
        f.kf.0 = 0.0;
        break;
    });
    each_cycle!(f in control => {
        f.pf.0 = 0.0;
    });
    assert_eq!((control.filters().kf.0, control.filters().pf.0), (0.003, 0.001));
}
