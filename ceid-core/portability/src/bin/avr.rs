//! The demo on ATmega328P: time is read from its timer, output goes to its serial port.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

use ceid_core::Time;
use core::fmt::Write as _;

#[path = "../board.rs"]
mod board;
#[path = "../demo.rs"]
mod demo;

/// Extends the timer, which starts again every quarter of a second, in software.
struct TimerTime {
    timer: board::Timer,
    overflows: u16,
}

impl Time for TimerTime {
    fn now_ns(&mut self) -> u64 {
        const NS_PER_COUNT: u64 = 64 * 1_000_000_000 / board::CLOCKS_PER_S as u64;
        let mut count = self.timer.count();
        if self.timer.has_overflowed() {
            self.overflows += 1;
            count = self.timer.count();
        }
        (u64::from(self.overflows) << 16 | u64::from(count)) * NS_PER_COUNT
    }

    fn sleep_until_ns(&mut self, at_ns: u64) {
        while self.now_ns() < at_ns {}
    }
}

#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    let time = TimerTime { timer: board::Timer::start(board::Prescaler::By64), overflows: 0 };
    let _ = write!(board::Serial, "{}", demo::report(time));
    board::end()
}
