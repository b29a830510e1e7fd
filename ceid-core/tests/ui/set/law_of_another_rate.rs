//! E10: a law designed for 100 Hz cannot run at 1000 Hz.

use ceid_core::prelude::*;

struct Notch;

impl SampledFilter<Hz<100>> for Notch {
    fn update(&mut self, _: Tick<'_, Hz<100>>) {}
}

filters! { struct Filters @ 1000 Hz { notch: Notch } }

fn main() {}
