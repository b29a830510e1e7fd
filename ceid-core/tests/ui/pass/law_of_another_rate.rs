//! A law designed for 100 Hz runs in every tenth cycle at 1000 Hz.

use ceid_core::prelude::*;

struct Notch;

impl SampledFilter<Hz<100>> for Notch {
    fn update(&mut self, _: Tick<'_, Hz<100>>) {}
}

filters! { struct Filters @ 1000 Hz { notch: Notch, every 10 } }

fn main() {
    let _filters = Filters::register(Notch);
}
