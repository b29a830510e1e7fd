//! The step of a tick can be kept.

use ceid_core::prelude::*;

struct Hoard(Option<f64>);

impl SampledFilter<Hz<1000>> for Hoard {
    fn update(&mut self, tick: Tick<'_, Hz<1000>>) {
        self.0 = Some(tick.dt());
    }
}

fn main() {
    let mut control = Cyclic::new(Hoard(None), Free::new().take(1));
    each_cycle!(_hoard in control => {});
    assert_eq!(control.filters().0, Some(0.001));
}
