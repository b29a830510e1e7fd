//! E6: the guard of a macro has no name, so it can be neither forgotten nor dropped.

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
    each_cycle!(f in control => {
        f.kf.0 = 0.0;
        core::mem::forget(__ceid_guard);
    });
    let mut kf = KalmanF(0.0);
    let mut clock = Free::<Hz<1000>>::new();
    while let Some(cycle) = clock.next_cycle() {
        ceid!(cycle => kf);
        drop(__ceid_guard);
    }
}
