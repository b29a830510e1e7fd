//! The filters are registered in the order of their declaration, each as itself or as `Unregistered`.

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
    let filters = Filters::register(KalmanF(1.0), Unregistered::new(ParticleF(2.0)));
    assert_eq!((filters.kf.0, filters.pf.0), (1.0, 2.0));
}
