//! The filter is built where it is registered, and calls that may panic are allowed in between.

use ceid_core::prelude::*;

struct KalmanF {
    estimate: f64,
}

impl KalmanF {
    fn new(estimate: f64) -> Unregistered<Self> {
        Unregistered::new(Self { estimate })
    }
}

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.estimate += tick.dt();
    }
}

filters! { struct Filters @ 1000 Hz { kf: KalmanF } }

fn filters(text: &str) -> Option<Filters> {
    let offset: f64 = text.parse().ok()?;
    Some(Filters::register(KalmanF::new(offset + text.split('.').map(|part| part.len() as f64).sum::<f64>())))
}

fn main() {
    let kf = KalmanF::new(0.0);
    let offset: f64 = "1.5".parse().expect("a panic does not drop anything here");
    assert_eq!(Filters::register(kf).kf.estimate + offset, 1.5);
    assert_eq!(filters("1.5").map(|filters| filters.kf.estimate), Some(3.5));
}
