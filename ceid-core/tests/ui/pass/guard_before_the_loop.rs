//! Each pass of a loop takes its own cycle from the clock.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

fn main() {
    let mut kf = KalmanF(0.0);
    let mut clock = Free::<Hz<1000>>::new().take(2);
    loop {
        let Some(cycle) = clock.next_cycle() else { break };
        ceid!(cycle => kf);
    }
    assert_eq!(kf.0, 0.002);
}
