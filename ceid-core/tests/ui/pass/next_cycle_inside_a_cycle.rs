//! A loop of its own clock may run inside a cycle, with filters of its own.

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
        let mut pf = KalmanF(0.0);
        let mut inner = Free::<Hz<8000>>::new().take(8);
        while let Some(cycle) = inner.next_cycle() {
            ceid!(cycle => pf);
        }
        assert_eq!(pf.0, 0.001);
    }
    assert_eq!(kf.0, 0.001);
}
