//! The body may ask whether there is a measurement.

use ceid_core::prelude::*;

struct KalmanF {
    position: Sample<f64>,
    estimate: f64,
}

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        if let Some(position) = self.position.take(&tick) {
            self.estimate = position;
        }
    }
}

fn main() {
    let mut control = Cyclic::new(KalmanF { position: Sample::new(), estimate: 0.0 }, Free::<Hz<1000>>::new().take(5));
    each_cycle!(kf in control => {
        assert!(!kf.position.is_fresh());
        let _ = kf.position.put(4.0);
        assert!(kf.position.is_fresh());
    });
}
