//! The finite-state machine that says which behaviour the robot shows.

use ceid_core::prelude::*;

/// What the robot does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Mode {
    /// Stands still, because it does not know where the goal is or what is in its way.
    Waiting,
    Reaching,
    /// Passes an obstacle, on one side until it is past.
    Avoiding(Side),
    Arrived,
}

/// On which side of an obstacle the robot passes it: 1 on its left, -1 on its right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Side(f64);

impl Side {
    /// Left for what is positive, as angles are.
    pub(crate) fn towards(angle: f64) -> Self {
        Self(1.0_f64.copysign(angle))
    }

    pub(crate) fn sign(self) -> f64 {
        self.0
    }
}

/// What the machine is told in each cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Situation {
    Blind,
    /// In metres from the goal, with nothing in the way.
    Clear(f64),
    /// An obstacle in the way, with the side on which it is passed more easily.
    Blocked(Side),
}

/// Holds the mode, and changes it once per cycle at most.
#[derive(Debug)]
pub(crate) struct ModeMachine {
    mode: Mode,
    pub(crate) situation: Situation,
    /// For how many cycles the situation has been another than the mode.
    cycles: u32,
}

impl ModeMachine {
    /// How near the goal is the goal, and how far it is left again, in metres.
    const ARRIVED: f64 = 0.06;
    const LEFT: f64 = 0.25;
    /// How many cycles an obstacle has to be out of the way.
    const PAST: u32 = 100;

    pub(crate) fn new() -> Unregistered<Self> {
        Unregistered::new(Self { mode: Mode::Waiting, situation: Situation::Blind, cycles: 0 })
    }

    pub(crate) fn mode(&self) -> Mode {
        self.mode
    }

    fn next(&self) -> Mode {
        // Who has arrived stays so, also if the goal seems to move a little.
        let near = if self.mode == Mode::Arrived { Self::LEFT } else { Self::ARRIVED };
        match (self.mode, self.situation) {
            (_, Situation::Blind) => Mode::Waiting,
            (Mode::Avoiding(side), Situation::Blocked(_)) | (_, Situation::Blocked(side)) => Mode::Avoiding(side),
            (Mode::Avoiding(side), _) if self.cycles < Self::PAST => Mode::Avoiding(side),
            (_, Situation::Clear(distance)) if distance < near => Mode::Arrived,
            _ => Mode::Reaching,
        }
    }
}

impl<R: Rate> SampledFilter<R> for ModeMachine {
    fn update(&mut self, _: Tick<'_, R>) {
        let is_past = matches!((self.mode, self.situation), (Mode::Avoiding(_), Situation::Clear(_)));
        self.cycles = if is_past { self.cycles + 1 } else { 0 };
        self.mode = self.next();
    }
}
