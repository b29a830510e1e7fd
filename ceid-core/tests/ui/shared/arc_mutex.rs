//! E13: a lock behind a shared handle is no filter either.

use ceid_core::prelude::*;

use std::sync::{Arc, Mutex};

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

fn main() {
    let mut kf = Arc::new(Mutex::new(KalmanF(0.0)));
    let mut clock = Free::<Hz<1000>>::new();
    while let Some(cycle) = clock.next_cycle() {
        ceid!(cycle => kf);
    }
}
