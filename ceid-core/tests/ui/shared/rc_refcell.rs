//! E13: a shared handle is no filter, because two handles could run one law twice.

use ceid_core::prelude::*;

use std::cell::RefCell;
use std::rc::Rc;

struct KalmanF(f64);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.0 += tick.dt();
    }
}

filters! { struct Filters @ 1000 Hz { kf: Rc<RefCell<KalmanF>>; again: Rc<RefCell<KalmanF>> } }

fn main() {}
