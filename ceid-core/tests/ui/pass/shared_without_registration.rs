//! The second registration of a shared filter is refused, until the first one is over.

use ceid_core::Shared;
use ceid_core::prelude::*;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

fn main() {
    let kf = Shared::new(KalmanF(0.0));
    let registration = Shared::try_register(&kf).expect("it is the first");
    assert!(Shared::try_register(&kf).is_err());
    let mut control = Cyclic::new(registration, Free::<Hz<1000>>::new().take(3));
    each_cycle!(_f in control => { kf.with(|kf| kf.0 += 1.0) });
    assert!((kf.with(|kf| kf.0) - 3.003).abs() < 1e-9);
    drop(control);
    assert!(Shared::try_register(&kf).is_ok());
}
