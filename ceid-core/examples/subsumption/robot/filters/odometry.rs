//! Where the wheels have brought the robot.

use crate::robot::signals::{Motion, chassis};
use crate::robot::vector::Vector;
use ceid_core::prelude::*;

/// Adds up how far the wheels have rolled. They count from the beginning, so nothing is lost in a gap.
#[derive(Debug)]
pub(crate) struct Odometry {
    motion: Motion,
    /// Of the left and the right wheel.
    before: [f64; 2],
    rolled: Sample<[f64; 2]>,
}

impl Odometry {
    pub(crate) fn new() -> Unregistered<Self> {
        Unregistered::new(Self { motion: Motion::AT_START, before: [0.0; 2], rolled: Sample::new() })
    }

    /// Hands to the law how far the wheels have rolled since the beginning.
    pub(crate) fn roll(&mut self, left: f64, right: f64) {
        if left.is_finite() && right.is_finite() {
            self.rolled.put([left, right]);
        }
    }

    pub(crate) fn motion(&self) -> Motion {
        self.motion
    }
}

impl<R: Rate> SampledFilter<R> for Odometry {
    fn update(&mut self, tick: Tick<'_, R>) {
        let Some(rolled) = self.rolled.take(&tick) else { return };
        let [left, right] = [rolled[0] - self.before[0], rolled[1] - self.before[1]];
        let turn = Vector::rotation((right - left) / chassis::TRACK);
        let after = self.motion.heading.turned_by(turn);
        let middle = (self.motion.heading + after).direction();
        self.motion.position = self.motion.position + middle * ((left + right) / 2.0);
        self.motion.heading = after.direction();
        self.before = rolled;
    }
}
