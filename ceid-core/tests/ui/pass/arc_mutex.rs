//! A locked filter can be guarded by the loop that holds the lock.

use ceid_core::prelude::*;

use std::sync::{Arc, Mutex};

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

fn main() {
    let shared = Arc::new(Mutex::new(KalmanF(0.0)));
    let mut clock = Free::<Hz<1000>>::new().take(1);
    while let Some(cycle) = clock.next_cycle() {
        let mut kf = shared.lock().unwrap();
        ceid!(cycle => kf);
        kf.0 = 1.0;
    }
    assert_eq!(shared.lock().unwrap().0, 1.001);
}
