//! A closure form is the shortest way to run a law.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

fn main() {
    let mut control = Cyclic::new(KalmanF(0.0), Free::<Hz<1000>>::new());
    let start = control.run(|kf, _| core::ops::ControlFlow::Break(kf.0));
    assert_eq!((start, control.filters().0), (Some(0.0), 0.001));
}
