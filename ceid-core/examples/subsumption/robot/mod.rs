//! The robot of the paper: functionalities with filters of their own, wired by transactions, and run by any thread.
//!
//! Needs neither the standard library nor allocation, and computes the same on every processor.

mod computer_vision;
mod filters;
mod motor_control;
mod random;
mod sa_interference;
mod sensor_recognition;
pub(crate) mod signals;
pub(crate) mod vector;
pub(crate) mod world;

use ceid_core::prelude::*;
use ceid_core::thread::{Outcome, Task, Until};
use computer_vision::ComputerVision;
use core::time::Duration;
use motor_control::MotorControl;
use sa_interference::SaInterference;
use sensor_recognition::SensorRecognition;
use signals::{Command, Echo, Encoders, Frame, Motion, TransactionIo, Voltages};
use vector::Vector;
use world::{Body, Fault, World};

/// One run of the robot.
#[derive(Debug, Clone)]
pub(crate) struct Trip {
    /// How strongly avoiding interferes with reaching.
    pub(crate) intensity: f64,
    /// Of the noise of the sensors.
    pub(crate) seed: u64,
    pub(crate) duration: Duration,
    pub(crate) fault: Fault,
    pub(crate) overrun: Overrun,
}

impl Trip {
    pub(crate) fn new(intensity: f64) -> Self {
        let duration = Duration::from_secs(7);
        Self { intensity, seed: 1, duration, fault: Fault::None, overrun: Overrun::Skip }
    }
}

/// What became of a trip.
#[derive(Debug)]
pub(crate) struct Journey<Report> {
    /// How many points of the path were recorded.
    pub(crate) points: usize,
    /// The smallest distance between the outlines of robot and obstacle, in metres; negative if they met.
    pub(crate) clearance: f64,
    /// The releases without a cycle, of all tasks.
    pub(crate) missed: u64,
    /// How late the latest cycle began.
    pub(crate) late: Duration,
    /// Why it ended, for the world.
    pub(crate) outcome: Option<Outcome>,
    pub(crate) report: Report,
}

impl<Report> Journey<Report> {
    pub(crate) fn map_report<R>(self, change: impl FnOnce(Report) -> R) -> Journey<R> {
        let Self { points, clearance, missed, late, outcome, report } = self;
        Journey { points, clearance, missed, late, outcome, report: change(report) }
    }
}

/// Drives the robot in whatever world the thread runs it, and records a point of its path every 0.1 s.
pub(crate) fn drive<T: RealtimeThread>(thread: &mut T, trip: &Trip, path: &mut [Vector]) -> Journey<T::Report> {
    // The devices of the robot.
    let mut camera = TransactionIo::new((), Frame::default());
    let mut range_finder = TransactionIo::new((), Echo::default());
    let mut wheels = TransactionIo::new(Voltages::default(), Encoders::default());
    // Its functionalities.
    let mut vision = TransactionIo::new(Motion::AT_START, None);
    let mut recognition = TransactionIo::new(Motion::AT_START, None);
    let mut motor = TransactionIo::new(Command::default(), Motion::AT_START);

    let (camera_user, camera) = camera.split();
    let (range_finder_user, range_finder) = range_finder.split();
    let (drive_user, drive) = wheels.split();
    let (vision_user, vision) = vision.split();
    let (recognition_user, recognition) = recognition.split();
    let (motor_user, motor) = motor.split();

    let robot = Body::AT_START;
    let (seed, fault) = (trip.seed, trip.fault.clone());
    let world = World { drive, camera, range_finder, seed, fault, robot, path, recorded: 0, steps: 0 };
    let (clock, filters) = (Free::new(), computer_vision::filters());
    let vision = ComputerVision { clock, filters, io: vision, camera: camera_user };
    let (clock, filters) = (Free::new(), sensor_recognition::filters());
    let recognition = SensorRecognition { clock, filters, io: recognition, range_finder: range_finder_user };
    let (clock, filters) = (Free::new(), motor_control::filters());
    let motor = MotorControl { clock, filters, io: motor, drive: drive_user };
    let (clock, filters) = (Free::new(), sa_interference::filters());
    let intensity = trip.intensity;
    let interference = SaInterference {
        clock,
        filters,
        intensity,
        vision: vision_user,
        recognition: recognition_user,
        motor: motor_user,
    };

    let mut world = Task::new("world", world, trip.overrun);
    let mut vision = Task::new("vision", vision, trip.overrun);
    let mut recognition = Task::new("recognition", recognition, trip.overrun);
    let mut interference = Task::new("interference", interference, trip.overrun);
    let mut motor = Task::new("motor", motor, trip.overrun);
    // The world ends the run when it has recorded the last point, which is late if its thread is.
    let until = Until::duration(trip.duration + Duration::from_secs(1));
    let report = thread.run(&mut [&mut world, &mut vision, &mut recognition, &mut interference, &mut motor], until);

    let missed = world.missed() + vision.missed() + recognition.missed() + interference.missed() + motor.missed();
    let late_ns = [
        world.lateness().max_ns(),
        vision.lateness().max_ns(),
        recognition.lateness().max_ns(),
        interference.lateness().max_ns(),
        motor.lateness().max_ns(),
    ];
    Journey {
        points: world.functionality().recorded,
        clearance: world.functionality().robot.clearance,
        missed,
        late: Duration::from_nanos(late_ns.into_iter().max().unwrap_or(0)),
        outcome: world.outcome(),
        report,
    }
}

/// Of every bit of a path (FNV-1a, a word at a time).
pub(crate) fn hash(path: &[Vector]) -> u64 {
    let words = path.iter().flat_map(|point| [point.x.to_bits(), point.y.to_bits()]);
    words.fold(0xcbf2_9ce4_8422_2325, |hash, word| (hash ^ word).wrapping_mul(0x0100_0000_01b3))
}
