//! The threads that run the robot: the one place that tells them apart.

use crate::robot::vector::Vector;
use crate::robot::{self, Journey, Trip};
use ceid_core::thread::{ChronoCycleThread, SimulatedCycleThread};
use std::io::{self, IsTerminal as _, Write as _};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum World {
    Simulated,
    Soft,
    RealTime,
}

impl World {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Simulated => "simulated",
            Self::Soft => "soft",
            Self::RealTime => "real-time",
        }
    }
}

/// The report is what the operating system refused, for the reader.
pub(crate) fn drive(world: World, trip: &Trip, path: &mut [Vector]) -> Result<Journey<String>, String> {
    match world {
        World::Simulated => {
            Ok(robot::drive(&mut SimulatedCycleThread::new(), trip, path).map_report(|()| String::new()))
        }
        World::Soft => with_progress(trip, || {
            Ok(robot::drive(&mut ChronoCycleThread::new(), trip, path).map_report(|report| report.to_string()))
        }),
        World::RealTime => with_progress(trip, || real_time(trip, path)),
    }
}

#[cfg(all(feature = "linux-rt", target_os = "linux"))]
fn real_time(trip: &Trip, path: &mut [Vector]) -> Result<Journey<String>, String> {
    use ceid_core::thread::{IfRefused, RtPreemptCycleThread, Scheduling};
    let mut thread = RtPreemptCycleThread::new(Scheduling::Fifo { priority: 50 }, IfRefused::RunAnyway);
    Ok(robot::drive(&mut thread, trip, path).map_report(|report| report.to_string()))
}

#[cfg(not(all(feature = "linux-rt", target_os = "linux")))]
fn real_time(_: &Trip, _: &mut [Vector]) -> Result<Journey<String>, String> {
    Err("The real-time thread is for Linux, with the feature `linux-rt`; run with `--thread soft` here".to_owned())
}

/// Tells how far a run is that takes its time.
fn with_progress<T>(trip: &Trip, run: impl FnOnce() -> T) -> T {
    let (over, is_over) = mpsc::channel::<()>();
    thread::scope(|scope| {
        scope.spawn(move || {
            let start = Instant::now();
            let is_terminal = io::stderr().is_terminal();
            let (pace, end) = if is_terminal { (100, "\r") } else { (1000, "\n") };
            while is_over.recv_timeout(Duration::from_millis(pace)) == Err(mpsc::RecvTimeoutError::Timeout) {
                let (now, all) = (start.elapsed().as_secs_f64(), trip.duration.as_secs_f64());
                let _ = write!(io::stderr(), "intensity {}: {now:4.1} s of {all:.1} s{end}", trip.intensity);
            }
            if is_terminal {
                // The line is taken back.
                let _ = write!(io::stderr(), "\r\x1b[K");
            }
        });
        let result = run();
        drop(over);
        result
    })
}
