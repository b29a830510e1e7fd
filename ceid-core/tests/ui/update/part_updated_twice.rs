//! E12: a composite cannot update the same part twice.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

struct Both {
    kf: KalmanF,
    pf: KalmanF,
}

impl<R: Rate> SampledFilter<R> for Both {
    fn update(&mut self, tick: Tick<'_, R>) {
        tick.then(&mut self.kf).then(&mut self.kf).done();
    }
}

fn main() {
    let mut control = Cyclic::new(Both { kf: KalmanF(0.0), pf: KalmanF(0.0) }, Free::<Hz<1000>>::new().take(1));
    each_cycle!(_both in control => {});
    assert_eq!(control.filters().kf.0, control.filters().pf.0);
}
