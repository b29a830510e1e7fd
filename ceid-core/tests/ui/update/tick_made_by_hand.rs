//! E1: a tick cannot be made outside the library.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

fn main() {
    let mut kf = KalmanF(0.0);
    kf.update(Tick::<Hz<1000>> { parts: core::marker::PhantomData });
}
