//! E3: the same variable cannot be listed twice.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

fn main() {
    let mut kf = KalmanF(0.0);
    let mut clock = Free::<Hz<1000>>::new();
    while let Some(cycle) = clock.next_cycle() {
        ceid!(cycle => kf, kf);
    }
}
