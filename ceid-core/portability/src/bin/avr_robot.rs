//! The paper's robot on ATmega1284P, which has the memory for its particles. Output goes to its serial port.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

#[path = "../board.rs"]
#[allow(dead_code, reason = "the demo uses all of it")]
mod board;
#[path = "../../../examples/subsumption/robot/mod.rs"]
#[allow(dead_code, reason = "the example uses all of it")]
mod robot;
#[path = "../robot_paths.rs"]
mod robot_paths;

#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    let _ = robot_paths::print::<71>(&mut board::Serial, 7);
    board::end()
}
