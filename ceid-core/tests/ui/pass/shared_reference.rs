//! An exclusive reference is one, as there is only one of it.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

fn main() {
    let (mut kf, mut pf) = (KalmanF(0.0), KalmanF(0.0));
    each_cycle!(_f in Cyclic::new((&mut kf, &mut pf), Free::<Hz<1000>>::new().take(1)) => {});
    assert_eq!((kf.0, pf.0), (0.001, 0.001));
}
