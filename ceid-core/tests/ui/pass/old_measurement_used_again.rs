//! A measurement is used once; without one, the law predicts.

use ceid_core::prelude::*;

struct KalmanF {
    position: Sample<f64>,
    estimate: f64,
}

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        if let Some(position) = self.position.take(&tick) {
            self.estimate += tick.dt() * (position - self.estimate);
        }
    }
}

fn main() {
    let mut control = Cyclic::new(KalmanF { position: Sample::new(), estimate: 0.0 }, Free::<Hz<1000>>::new().take(5));
    each_cycle!(kf, info in control => {
        if info.n == 2 {
            assert_eq!(kf.position.put(4.0), None);
            assert_eq!(kf.position.put(5.0), Some(4.0), "it is told that one is lost");
        }
    });
    assert_eq!((control.filters().estimate, control.filters().position.age()), (0.005, Some(2)));
}
