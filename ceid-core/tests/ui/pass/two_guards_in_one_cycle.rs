//! One guard takes all filters of a cycle.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

fn main() {
    let mut kf = KalmanF(0.0);
    let mut pf = KalmanF(0.0);
    let mut clock = Free::<Hz<1000>>::new().take(1);
    while let Some(cycle) = clock.next_cycle() {
        ceid!(cycle => kf, pf,);
    }
    assert_eq!((kf.0, pf.0), (0.001, 0.001));
}
