//! The loop under a guard.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

use ceid_core::prelude::*;
use clocks::LowPass;

#[path = "../board.rs"]
#[allow(dead_code, reason = "the demo uses all of it")]
mod board;
#[path = "../clocks.rs"]
mod clocks;

filters! { struct Filters @ 1000 Hz { speed: LowPass; mean: LowPass } }

#[inline(never)]
fn control_loop() -> [i32; 2] {
    let filters = Filters::register(LowPass::new(), LowPass::new());
    let mut control = Cyclic::new(filters, Free::<Hz<1000>>::new().take(clocks::CYCLES));
    each_cycle!(f, info in control => {
        f.speed.input = clocks::position(info.n);
        if f.speed.input > 60 { continue }
        f.mean.input = f.speed.output;
    });
    [control.filters().speed.output, control.filters().mean.output]
}

#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    clocks::measure(control_loop)
}
