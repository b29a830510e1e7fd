//! E14: a reference to a filter cannot leave the closure of its cycle.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

filters! { struct Filters @ 1000 Hz { kf: KalmanF; pf: KalmanF } }

fn main() {
    let mut control = Cyclic::new(Filters::register(KalmanF(0.0), KalmanF(0.0)), Free::<Hz<1000>>::new().take(3));
    let mut kept: Option<&f64> = None;
    control.run(|f, _| {
        kept = Some(&f.pf.0);
        core::ops::ControlFlow::Break(())
    });
    assert!(kept.is_some());
}
