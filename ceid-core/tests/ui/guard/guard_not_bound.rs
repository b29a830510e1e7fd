//! E5: a guard that is not bound ends at once; with the lints of the README this does not compile.

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
    control.cycle();
    let _ = control.cycle();
}
