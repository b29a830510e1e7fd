//! E4: a filter built for `ceid!` and never prepared for it.

use ceid_core::prelude::*;

struct KalmanF {
    estimate: f64,
}

impl KalmanF {
    fn new(estimate: f64) -> Unregistered<Self> {
        Unregistered::new(Self { estimate })
    }
}

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.estimate += tick.dt();
    }
}

fn main() {
    let _kf = KalmanF::new(0.0);
    let mut pf = KalmanF::new(1.0).only_in_ceid();
    let mut clock = Free::<Hz<1000>>::new().take(3);
    while let Some(cycle) = clock.next_cycle() {
        ceid!(cycle => pf);
    }
}
