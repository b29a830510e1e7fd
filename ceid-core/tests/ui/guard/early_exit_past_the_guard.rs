//! E8: an early exit jumps out of the body, past the guard that would update the filter.

use ceid_core::prelude::*;
use core::ops::ControlFlow;

#[derive(Default)]
struct KalmanF(u32);

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, _: Tick<'_, R>) {
        self.0 += 1;
    }
}

fn main() {
    let mut control = Cyclic::new(KalmanF::default(), Free::<Hz<1000>>::new().take(9));
    'robot: loop {
        control.run(|_kf, info| -> ControlFlow<()> {
            if info.n == 3 {
                continue 'robot;
            }
            ControlFlow::Continue(())
        });
        break;
    }
}
