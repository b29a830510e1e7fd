//! The ATmega328P as the programs for AVR need it: a timer, a serial port, and an end.

use core::arch::asm;
use core::fmt;
use core::panic::PanicInfo;
use core::ptr::{read_volatile, write_volatile};

// Addresses of the data sheet, section "Register Summary".
const TIMER_CONTROL: *mut u8 = 0x81 as *mut u8;
const TIMER_COUNT: *mut u16 = 0x84 as *mut u16;
const TIMER_FLAGS: *mut u8 = 0x36 as *mut u8;
const SERIAL_STATUS: *mut u8 = 0xc0 as *mut u8;
const SERIAL_CONTROL: *mut u8 = 0xc1 as *mut u8;
const SERIAL_DATA: *mut u8 = 0xc6 as *mut u8;

pub const CLOCKS_PER_S: u32 = 16_000_000;

/// How many clocks one count of the timer takes.
#[derive(Clone, Copy)]
#[repr(u8)]
#[allow(dead_code, reason = "each program uses one")]
pub enum Prescaler {
    By1 = 1,
    By64 = 3,
}

/// Timer 1, which counts to 65535 and starts again.
pub struct Timer(());

impl Timer {
    pub fn start(prescaler: Prescaler) -> Self {
        // SAFETY: registers of this chip, which nothing else in the program uses.
        unsafe { write_volatile(TIMER_CONTROL, prescaler as u8) };
        Self(())
    }

    #[inline]
    pub fn count(&mut self) -> u16 {
        // SAFETY: as in `start`. The compiler reads the low byte first, which latches the high one.
        unsafe { read_volatile(TIMER_COUNT) }
    }

    /// Whether the timer has started again since this was last asked.
    #[allow(dead_code, reason = "each program uses a part")]
    pub fn has_overflowed(&mut self) -> bool {
        // SAFETY: as in `start`. A flag is cleared by writing it.
        unsafe {
            let overflowed = read_volatile(TIMER_FLAGS) & 1 != 0;
            if overflowed {
                write_volatile(TIMER_FLAGS, 1);
            }
            overflowed
        }
    }
}

/// The serial port, which the simulator prints.
pub struct Serial;

impl fmt::Write for Serial {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            // SAFETY: registers of this chip, which nothing else in the program uses.
            unsafe {
                write_volatile(SERIAL_CONTROL, 1 << 3);
                while read_volatile(SERIAL_STATUS) & 1 << 5 == 0 {}
                write_volatile(SERIAL_DATA, byte);
            }
        }
        Ok(())
    }
}

/// Ends the simulation: nothing can wake a processor that sleeps with its interrupts off.
pub fn end() -> ! {
    loop {
        // SAFETY: no interrupt is used, and enabling sleep changes nothing else.
        unsafe {
            write_volatile(0x53 as *mut u8, 1);
            asm!("cli", "sleep");
        }
    }
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    let _ = fmt::Write::write_str(&mut Serial, "panicked\n");
    end()
}
