//! The set owns the filter; what it measures may be shared.

use ceid_core::prelude::*;

use std::cell::Cell;
use std::rc::Rc;

struct KalmanF {
    measured: Rc<Cell<f64>>,
    estimate: f64,
}

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, _: Tick<'_, R>) {
        self.estimate += (self.measured.get() - self.estimate) * 0.5;
    }
}

filters! { struct Filters @ 1000 Hz { kf: KalmanF } }

fn main() {
    let measured = Rc::new(Cell::new(2.0));
    let kf = KalmanF { measured: Rc::clone(&measured), estimate: 0.0 };
    each_cycle!(_f in Cyclic::new(Filters::register(kf), Free::<Hz<1000>>::new().take(1)) => {
        measured.set(4.0);
    });
}
