//! An inner loop uses what the guard of the cycle hands out.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

fn main() {
    let mut kf = KalmanF(0.0);
    let mut clock = Free::<Hz<1000>>::new().take(1);
    while let Some(cycle) = clock.next_cycle() {
        ceid!(cycle => kf);
        for _ in 0..4 {
            kf.0 += 1.0;
        }
    }
    assert_eq!(kf.0, 4.001);
}
