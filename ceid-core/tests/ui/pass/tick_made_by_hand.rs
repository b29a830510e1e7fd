//! A test of a single law gets its ticks from a clock.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

fn main() {
    let mut control = Cyclic::new(KalmanF(0.0), Free::<Hz<1000>>::new().take(2));
    each_cycle!(kf in control => { kf.0 *= 2.0 });
    assert_eq!(control.filters().0, 0.003);
}
