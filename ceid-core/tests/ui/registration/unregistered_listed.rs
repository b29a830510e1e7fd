//! E4: a filter that was not prepared for `ceid!` cannot be listed in it.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl KalmanF {
    fn new() -> Unregistered<Self> {
        Unregistered::new(Self(0.0))
    }

    fn measure(&mut self, position: f64) {
        self.0 = position;
    }
}

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

fn main() {
    let mut kf = KalmanF::new();
    let mut clock = Free::<Hz<1000>>::new().take(3);
    while let Some(cycle) = clock.next_cycle() {
        ceid!(cycle => kf);
        kf.measure(1.0);
    }
}
