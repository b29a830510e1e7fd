//! E16: the body cannot take a measurement away from the law.

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
        let _ = kf.position.put(4.0);
        println!("{:?}", kf.position.take());
    });
}
