//! E13: a shared reference is no filter.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

fn main() {
    let kf = KalmanF(0.0);
    let _control = Cyclic::new((&kf, &kf), Free::<Hz<1000>>::new());
}
