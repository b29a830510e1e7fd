//! E4: the filters are registered in the order of their declaration.

use ceid_core::prelude::*;

struct KalmanF(f64);
struct ParticleF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

impl<R: Rate> SampledFilter<R> for ParticleF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

filters! { struct Filters @ 1000 Hz { kf: KalmanF; pf: ParticleF } }

fn main() {
    let _filters = Filters::register(ParticleF(0.0), KalmanF(0.0));
}
