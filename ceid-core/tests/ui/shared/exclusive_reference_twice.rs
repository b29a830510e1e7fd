//! E3: two exclusive references to one filter do not exist.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

fn main() {
    let mut kf = KalmanF(0.0);
    let _control = Cyclic::new((&mut kf, &mut kf), Free::<Hz<1000>>::new());
}
