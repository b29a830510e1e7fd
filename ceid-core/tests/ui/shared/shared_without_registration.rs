//! E13: a shared filter in two sets, past the check of its registration.

use ceid_core::Shared;
use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

fn main() {
    let kf = Shared::new(KalmanF(0.0));
    let _first = Cyclic::new(&kf, Free::<Hz<1000>>::new());
    let _second = Cyclic::new(&kf, Free::<Hz<1000>>::new());
}
