//! E12: a tick cannot be kept for another cycle.

use ceid_core::prelude::*;

struct Hoard(Option<Tick<'static, Hz<1000>>>);

impl SampledFilter<Hz<1000>> for Hoard {
    fn update(&mut self, tick: Tick<'_, Hz<1000>>) {
        self.0 = Some(tick);
    }
}

fn main() {}
