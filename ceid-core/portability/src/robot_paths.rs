//! The paths of the paper's robot (the example `subsumption`) in virtual time, where every target must compute the same.

use crate::robot::vector::Vector;
use crate::robot::{self, Trip};
use ceid_core::thread::SimulatedCycleThread;
use core::fmt::{self, Write};
use core::time::Duration;

/// Prints one line for each duration; a point lies every 0.1 s.
pub fn print<const POINTS: usize>(to: &mut impl Write, seconds: u64) -> fmt::Result {
    let mut path = [Vector::default(); POINTS];
    let trip = Trip { duration: Duration::from_secs(seconds), ..Trip::new(2.0) };
    let journey = robot::drive(&mut SimulatedCycleThread::new(), &trip, &mut path);
    writeln!(to, "robot, {seconds} s: {} points, path {:016x}", journey.points, robot::hash(&path))
}
