//! Lets the behaviours interfere with each other: reaching the goal, and avoiding what is in the way.

use super::filters::{Mode, ModeMachine, Ramp, Remembered, Side, Situation};
use super::signals::{Command, Motion, Outside, chassis};
use super::vector::Vector;
use ceid_core::prelude::*;

filters! {
    pub(crate) struct Filters @ 1000 Hz {
        goal: Remembered<Option<Vector>>;
        obstacle: Remembered<Option<Vector>>;
        machine: ModeMachine;
        speed: Ramp;
        turn: Ramp;
    }
}

/// Mediates between the functionalities, of which it knows what they take and give.
pub(crate) struct SaInterference<'t> {
    pub(crate) clock: ClockOf<Self>,
    pub(crate) filters: OnlyInCeid<Filters>,
    /// How strongly avoiding interferes with reaching; at 0 not at all.
    pub(crate) intensity: f64,
    pub(crate) vision: Outside<'t, Motion, Option<Vector>>,
    pub(crate) recognition: Outside<'t, Motion, Option<Vector>>,
    pub(crate) motor: Outside<'t, Command, Motion>,
}

/// In metres per second, and per second.
const CRUISE: f64 = 1.1;
const TURN_GAIN: f64 = 5.0;
/// From where on the robot slows down for its goal, in metres.
const BRAKING: f64 = 0.5;
/// From where on an obstacle interferes, in metres from the robot's outline.
const INFLUENCE: f64 = 0.9;
/// For how many cycles another functionality is believed without a word from it: a fifth of a second.
const PATIENCE: u32 = 200;

pub(crate) fn filters() -> OnlyInCeid<Filters> {
    OnlyInCeid::new(Filters::register(
        Remembered::nothing(),
        Remembered::nothing(),
        ModeMachine::new(),
        Ramp::new(2.5),
        Ramp::new(30.0),
    ))
}

/// What is known in one cycle.
struct Scene {
    motion: Motion,
    /// From the robot, as the obstacle is.
    goal: Vector,
    obstacle: Vector,
}

impl Scene {
    /// Only if everything is known that the robot needs to move.
    fn of(motion: Motion, goal: Option<Vector>, obstacle: Option<Vector>) -> Option<Self> {
        Some(Self { motion, goal: goal? - motion.position, obstacle: obstacle? - motion.position })
    }

    /// How much the obstacle matters, from 0 to 1: more when it is near, and not when it is past.
    fn threat(&self) -> f64 {
        let nearness = 1.0 - (self.obstacle.length() - chassis::RADIUS) / INFLUENCE;
        let ahead = self.obstacle.direction().dot(self.goal.direction()) + 0.3;
        nearness.clamp(0.0, 1.0) * ahead.clamp(0.0, 1.0)
    }

    fn situation(&self) -> Situation {
        if self.threat() > 0.0 {
            Situation::Blocked(Side::towards(self.obstacle.cross(self.goal)))
        } else {
            Situation::Clear(self.goal.length())
        }
    }

    /// Past the obstacle, and a little away from it.
    fn avoid(&self, side: Side) -> Vector {
        let obstacle = self.obstacle.direction();
        (obstacle.to_the_left() * side.sign() - obstacle * 0.6) * self.threat()
    }

    /// The interference: a sum of what both behaviours wish.
    fn command(&self, mode: Mode, intensity: f64) -> Command {
        let reach = self.goal.direction();
        match mode {
            Mode::Waiting | Mode::Arrived => Command::default(),
            Mode::Reaching => self.drive(reach),
            Mode::Avoiding(side) => self.drive(reach + self.avoid(side) * intensity),
        }
    }

    fn drive(&self, wish: Vector) -> Command {
        let wish = wish.seen_along(self.motion.heading).direction();
        let turn = if wish.x > 0.0 { wish.y } else { 1.0_f64.copysign(wish.y) };
        let slowly = (self.goal.length() / BRAKING).clamp(0.1, 1.0);
        Command { speed: CRUISE * wish.x.max(0.1) * slowly, turn: TURN_GAIN * turn }
    }
}

impl RealtimeFunctionality for SaInterference<'_> {
    type Rate = Hz<1000>;

    fn cycle(&mut self, _: CycleInfo) -> Flow {
        let cycle = self.clock.begin_cycle();
        ceid!(cycle => f = self.filters);
        let motion = self.motor.output().value();
        self.vision.set_input(motion);
        self.recognition.set_input(motion);
        self.vision.output().fresh().into_iter().for_each(|goal| f.goal.put(goal));
        self.recognition.output().fresh().into_iter().for_each(|obstacle| f.obstacle.put(obstacle));
        self.motor.set_input(Command { speed: f.speed.value(), turn: f.turn.value() });

        let scene = Scene::of(motion, f.goal.get(PATIENCE).flatten(), f.obstacle.get(PATIENCE).flatten());
        f.machine.situation = scene.as_ref().map_or(Situation::Blind, Scene::situation);
        let mode = f.machine.mode();
        let command = scene.map_or(Command::default(), |scene| scene.command(mode, self.intensity));
        f.speed.wanted = command.speed;
        f.turn.wanted = command.turn;
        Flow::Continue
    }
}
