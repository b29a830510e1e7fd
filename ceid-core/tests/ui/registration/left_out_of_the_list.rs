//! E4: a filter made for `ceid!` cannot be used where no list has it.

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
    let mut kf = KalmanF::new().only_in_ceid();
    let mut pf = KalmanF::new().only_in_ceid();
    let mut clock = Free::<Hz<1000>>::new().take(3);
    while let Some(cycle) = clock.next_cycle() {
        ceid!(cycle => kf);
        kf.measure(1.0);
        pf.measure(kf.0);
    }
}
