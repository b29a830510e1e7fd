//! E4: the assertion finds a filter that no set updates.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

struct ParticleF;

impl<R: Rate> SampledFilter<R> for ParticleF {
    fn update(&mut self, _: Tick<'_, R>) {}
}

filters! { struct Filters @ 1000 Hz { kf: KalmanF } }
assert_updated_once!(Filters, ParticleF);

fn main() {}
