//! The demo on Cortex-M3 and M4F: time is counted by the SysTick interrupt, output goes through semihosting.
#![no_std]
#![no_main]

use ceid_core::Time;
use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::peripheral::Peripherals;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::{entry, exception};
use cortex_m_semihosting::{debug, hio, hprint};
use panic_semihosting as _;

#[path = "../demo.rs"]
mod demo;
#[path = "../../../examples/subsumption/robot/mod.rs"]
#[allow(dead_code, reason = "the example uses all of it")]
mod robot;
#[path = "../robot_paths.rs"]
mod robot_paths;

const TICKS_PER_S: u32 = 1_000;
/// Of the processors that QEMU gives these boards, about: the demo does not depend on it.
const CLOCKS_PER_S: u32 = 12_000_000;

static TICKS: AtomicU32 = AtomicU32::new(0);

#[exception]
fn SysTick() {
    TICKS.fetch_add(1, Ordering::Relaxed);
}

struct SysTickTime;

impl Time for SysTickTime {
    fn now_ns(&mut self) -> u64 {
        u64::from(TICKS.load(Ordering::Relaxed)) * 1_000_000
    }

    fn sleep_until_ns(&mut self, at_ns: u64) {
        while self.now_ns() < at_ns {
            cortex_m::asm::wfi();
        }
    }
}

#[entry]
fn main() -> ! {
    if let Some(peripherals) = Peripherals::take() {
        let mut timer = peripherals.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(CLOCKS_PER_S / TICKS_PER_S - 1);
        timer.clear_current();
        timer.enable_counter();
        timer.enable_interrupt();
        hprint!("{}", demo::report(SysTickTime));
        if let Ok(mut output) = hio::hstdout() {
            let _ = robot_paths::print::<11>(&mut output, 1);
            let _ = robot_paths::print::<71>(&mut output, 7);
        }
        debug::exit(debug::EXIT_SUCCESS);
    }
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
