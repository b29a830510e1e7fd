//! A named guard is bound.

#![deny(unused_must_use, let_underscore_drop)]

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
    while let Some(mut guard) = control.cycle() {
        let f = guard.filters();
        f.kf.0 = f.pf.0;
    }
    assert_eq!(control.filters().pf.0, 0.003);
}
