//! Two filters in integers, and how many clocks 100 cycles of their loop take.

use crate::board::{Prescaler, Serial, Timer, end};
use ceid_core::prelude::*;
use core::fmt::Write as _;
use core::hint::black_box;

pub struct LowPass {
    pub input: i32,
    pub output: i32,
}

impl LowPass {
    pub const fn new() -> Self {
        Self { input: 0, output: 0 }
    }

    #[inline]
    pub fn advance(&mut self) {
        self.output += (self.input - self.output) >> 3;
    }
}

impl<R: Rate> SampledFilter<R> for LowPass {
    #[inline]
    fn update(&mut self, _: Tick<'_, R>) {
        self.advance();
    }
}

/// What the body measures.
#[inline]
pub fn position(n: u64) -> i32 {
    black_box(n as i32 & 63)
}

pub const CYCLES: u64 = 100;

/// Prints the clocks of a loop, and the estimates with which it ends.
pub fn measure(control_loop: impl FnOnce() -> [i32; 2]) -> ! {
    let mut timer = Timer::start(Prescaler::By1);
    let before = timer.count();
    let estimates = black_box(control_loop());
    let clocks = timer.count().wrapping_sub(before);
    let _ = writeln!(Serial, "clocks: {clocks}, estimates: {estimates:?}");
    end()
}
