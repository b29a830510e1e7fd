//! Turns the wheels.

use super::filters::{KalmanF, Noise, Odometry, SpeedController};
use super::signals::{Command, Encoders, Inside, Motion, Outside, Voltages, chassis};
use ceid_core::prelude::*;

filters! {
    pub(crate) struct Filters @ 1000 Hz {
        left: Wheel;
        right: Wheel;
        odometry: Odometry;
    }
}

assert_updated_once!(Filters, Odometry);

filters! {
    pub(crate) struct Wheel @ 1000 Hz {
        rolled: KalmanF;
        speed: SpeedController;
    }
}

/// Makes the wheels turn as commanded, and tells where they have brought the robot.
pub(crate) struct MotorControl<'t> {
    pub(crate) clock: ClockOf<Self>,
    pub(crate) filters: OnlyInCeid<Filters>,
    pub(crate) io: Inside<'t, Command, Motion>,
    pub(crate) drive: Outside<'t, Voltages, Encoders>,
}

/// For how many cycles the wheels are driven without an answer of the encoders: 50 ms.
const PATIENCE: u32 = 50;

pub(crate) fn filters() -> OnlyInCeid<Filters> {
    let noise = Noise { acceleration: 20.0, measurement: 0.000_000_25 };
    let wheel = || Wheel::register(KalmanF::new(noise), SpeedController::new());
    OnlyInCeid::new(Filters::register(wheel(), wheel(), Odometry::new()))
}

impl Wheel {
    /// The voltage for a speed. None is the only safe one if nobody knows what the wheel does.
    fn drive(&mut self, wanted: f64) -> f64 {
        self.speed.follow(wanted, self.rolled.velocity());
        if self.rolled.age().is_some_and(|age| age <= PATIENCE) { self.speed.voltage() } else { 0.0 }
    }

    fn measure(&mut self, rolled: f64, is_after_a_gap: bool) {
        if is_after_a_gap {
            self.rolled.lose_position();
        }
        self.rolled.measure(rolled);
    }
}

impl RealtimeFunctionality for MotorControl<'_> {
    type Rate = Hz<1000>;

    fn cycle(&mut self, info: CycleInfo) -> Flow {
        let cycle = self.clock.begin_cycle();
        ceid!(cycle => f = self.filters);
        let command = self.io.input().value();
        let difference = command.turn * chassis::TRACK / 2.0;
        let left = f.left.drive(command.speed - difference);
        let right = f.right.drive(command.speed + difference);
        self.drive.set_input(Voltages { left, right });
        self.io.set_output(f.odometry.motion());
        if let Some(rolled) = self.drive.output().fresh() {
            // The laws know one step only: what rolled by in releases that were missed is no speed.
            f.left.measure(rolled.left, info.missed > 0);
            f.right.measure(rolled.right, info.missed > 0);
            f.odometry.roll(rolled.left, rolled.right);
        }
        Flow::Continue
    }
}
