//! Twin of `guard/early_exit_past_the_guard`: every early exit of the body leaves by way of the guard.

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
    control.run(|_kf, info| -> ControlFlow<()> {
        if info.n == 3 {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    });
    assert_eq!(control.filters().0, 4);
    'robot: loop {
        each_cycle!(_kf, info in control => {
            if info.n == 6 {
                break 'robot;
            }
        });
    }
    assert_eq!(control.filters().0, 7);
}
