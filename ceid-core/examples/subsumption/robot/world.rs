//! The simulated world: a field with a goal and an obstacle, and the devices of the robot on it.

use super::random::Random;
use super::signals::{Echo, Encoders, Frame, Inside, Motion, Voltages, chassis};
use super::vector::Vector;
use ceid_core::prelude::*;
use core::ops::Range;

/// In metres; the robot starts at the origin and looks along the x axis.
pub(crate) const GOAL: Vector = Vector::new(4.5, 0.0);
pub(crate) const OBSTACLE: Vector = Vector::new(2.25, -0.1);
pub(crate) const OBSTACLE_RADIUS: f64 = 0.35;

/// Cycles from one recorded point of the path to the next: 0.1 s.
pub(crate) const CYCLES_PER_POINT: u64 = 100;

/// What goes wrong, for as long as the numbers of the cycles are in the range.
#[derive(Debug, Clone, Default)]
pub(crate) enum Fault {
    #[default]
    None,
    /// No device answers. The motors go on with the last voltage they were given.
    Silent(Range<u64>),
    /// The camera, the range finder and the encoders send what is not a number.
    NotANumber(Range<u64>),
}

/// The devices see the world as it is but for their noise. Everybody else sees it through the devices.
pub(crate) struct World<'t> {
    pub(crate) drive: Inside<'t, Voltages, Encoders>,
    pub(crate) camera: Inside<'t, (), Frame>,
    pub(crate) range_finder: Inside<'t, (), Echo>,
    pub(crate) seed: u64,
    pub(crate) fault: Fault,
    pub(crate) robot: Body,
    /// Where the robot was every 0.1 s; the run ends when it is full.
    pub(crate) path: &'t mut [Vector],
    pub(crate) recorded: usize,
    pub(crate) steps: u64,
}

/// The robot as a body: two wheels on motors.
pub(crate) struct Body {
    pub(crate) motion: Motion,
    speeds: [f64; 2],
    rolled: [f64; 2],
    /// The smallest distance to the obstacle so far; negative if it was touched.
    pub(crate) clearance: f64,
}

impl Body {
    pub(crate) const AT_START: Self =
        Self { motion: Motion::AT_START, speeds: [0.0; 2], rolled: [0.0; 2], clearance: f64::MAX };

    /// The obstacle is flat: the robot can drive over it, but should not.
    fn step(&mut self, voltages: [f64; 2]) {
        const DT: f64 = <Hz<1000>>::DT;
        const TIME_CONSTANT: f64 = 0.05;
        for (wheel, voltage) in voltages.into_iter().enumerate() {
            let settled = chassis::FULL_SPEED * voltage.clamp(-1.0, 1.0);
            self.speeds[wheel] += (settled - self.speeds[wheel]) * DT / TIME_CONSTANT;
            self.rolled[wheel] += self.speeds[wheel] * DT;
        }
        let [left, right] = self.speeds;
        self.motion.position = self.motion.position + self.motion.heading * ((left + right) / 2.0 * DT);
        let turned = self.motion.heading.turned_by(Vector::rotation((right - left) / chassis::TRACK * DT));
        self.motion.heading = turned.direction();
        let distance = (OBSTACLE - self.motion.position).length();
        self.clearance = self.clearance.min(distance - OBSTACLE_RADIUS - chassis::RADIUS);
    }
}

impl World<'_> {
    fn record(&mut self) {
        if self.steps % CYCLES_PER_POINT == 0 {
            if let Some(point) = self.path.get_mut(self.recorded) {
                *point = self.robot.motion.position;
                self.recorded += 1;
            }
        }
    }

    fn answer(&mut self, frame: Frame, echo: Echo, encoders: Encoders) {
        self.camera.set_output(frame);
        self.range_finder.set_output(echo);
        self.drive.set_output(encoders);
    }

    fn frame(&self) -> Frame {
        let mut random = Random::of_release(self.seed, 1, self.steps);
        let noise = Vector::new(random.normal(), random.normal()) * 0.05;
        let goal = self.robot.motion.view_of(GOAL);
        // Now and then it takes something else for the goal.
        let is_mistaken = random.uniform() < 0.05;
        let mistake = Vector::new(4.0 * random.uniform(), 4.0 * random.uniform() - 2.0);
        Frame { goal: if is_mistaken { mistake } else { goal } + noise }
    }

    fn echo(&self) -> Echo {
        const RANGE: f64 = 1.5;
        let mut random = Random::of_release(self.seed, 2, self.steps);
        let obstacle = self.robot.motion.view_of(OBSTACLE);
        let distance = obstacle.length() - OBSTACLE_RADIUS + 0.01 * random.normal();
        Echo { nearest: (distance < RANGE).then(|| obstacle.direction() * distance.max(0.0)) }
    }

    fn encoders(&self) -> Encoders {
        // Whole marks only, half a millimetre apart.
        const MARKS_PER_METRE: f64 = 2000.0;
        let [left, right] = self.robot.rolled.map(|rolled| (rolled * MARKS_PER_METRE) as i64 as f64 / MARKS_PER_METRE);
        Encoders { left, right }
    }
}

impl RealtimeFunctionality for World<'_> {
    type Rate = Hz<1000>;

    /// The world does not miss what its thread misses.
    fn cycle(&mut self, info: CycleInfo) -> Flow {
        let Voltages { left, right } = self.drive.input().value();
        if info.n == 0 {
            self.record();
        }
        while self.steps < info.n {
            self.robot.step([left, right]);
            self.steps += 1;
            self.record();
        }
        match &self.fault {
            Fault::Silent(when) if when.contains(&info.n) => {}
            Fault::NotANumber(when) if when.contains(&info.n) => {
                let nowhere = Vector::new(f64::NAN, f64::NAN);
                let encoders = Encoders { left: f64::NAN, right: f64::NAN };
                self.answer(Frame { goal: nowhere }, Echo { nearest: Some(nowhere) }, encoders);
            }
            _ => self.answer(self.frame(), self.echo(), self.encoders()),
        }
        if self.recorded < self.path.len() { Flow::Continue } else { Flow::Stop }
    }
}
