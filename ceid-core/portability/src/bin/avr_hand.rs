//! The same loop with calls written by hand.
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

struct Filters {
    speed: LowPass,
    mean: LowPass,
}

#[inline(never)]
fn control_loop() -> [i32; 2] {
    let mut f = Filters { speed: LowPass::new(), mean: LowPass::new() };
    let mut clock = Free::<Hz<1000>>::new().take(clocks::CYCLES);
    while let Some(info) = clock.wait() {
        'body: {
            f.speed.input = clocks::position(info.n);
            if f.speed.input > 60 {
                break 'body;
            }
            f.mean.input = f.speed.output;
        }
        f.speed.advance();
        f.mean.advance();
    }
    [f.speed.output, f.mean.output]
}

#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    clocks::measure(control_loop)
}
