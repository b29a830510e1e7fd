//! A driver that borrows its filter gives it back.

use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

fn main() {
    let mut kf = KalmanF(0.0);
    for _ in 0..2 {
        each_cycle!(_f in Cyclic::new(&mut kf, Free::<Hz<1000>>::new().take(1)) => {});
    }
    assert_eq!(kf.0, 0.002);
}
