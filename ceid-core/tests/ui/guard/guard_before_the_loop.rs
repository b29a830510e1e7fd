//! E9: a guard before the loop would update once, at the end.

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
    let Some(cycle) = clock.next_cycle() else { return };
    loop {
        ceid!(cycle => kf);
    }
}
