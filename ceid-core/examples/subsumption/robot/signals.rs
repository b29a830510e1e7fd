//! What the parts of the robot tell each other. They know these values, and nothing of each other.

use super::vector::Vector;
use ceid_core::exchange::Latest;
use ceid_core::transaction;

/// How all values are handed over. `Locked<StdMutex>` does as well.
pub(crate) type Exchange = Latest;
pub(crate) type Inside<'t, I, O> = transaction::Inside<'t, I, O, Exchange>;
pub(crate) type Outside<'t, I, O> = transaction::Outside<'t, I, O, Exchange>;
pub(crate) type TransactionIo<I, O> = ceid_core::TransactionIo<I, O, Exchange>;

/// Where the robot believes it is, on a field whose origin and axis are its start.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Motion {
    pub(crate) position: Vector,
    pub(crate) heading: Vector,
}

impl Motion {
    pub(crate) const AT_START: Self = Self { position: Vector::new(0.0, 0.0), heading: Vector::new(1.0, 0.0) };

    /// The place on the field of something that the robot sees in front (x) and to the left (y) of it.
    pub(crate) fn place_of(&self, seen: Vector) -> Vector {
        self.position + seen.turned_by(self.heading)
    }

    /// How the robot sees a place on the field.
    pub(crate) fn view_of(&self, place: Vector) -> Vector {
        (place - self.position).seen_along(self.heading)
    }
}

/// What the motors are to do.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Command {
    /// In metres per second.
    pub(crate) speed: f64,
    /// In radians per second, to the left.
    pub(crate) turn: f64,
}

/// What the camera shows: where the goal is, in front and to the left of it.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Frame {
    pub(crate) goal: Vector,
}

/// What the range finder says: the nearest point of what is in its range, in front and to the left of it.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Echo {
    pub(crate) nearest: Option<Vector>,
}

/// How far each wheel has rolled, in metres.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Encoders {
    pub(crate) left: f64,
    pub(crate) right: f64,
}

/// What drives each wheel; 1 is the full voltage.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Voltages {
    pub(crate) left: f64,
    pub(crate) right: f64,
}

/// The robot, as far as its control knows it.
pub(crate) mod chassis {
    /// Of its outline, in metres.
    pub(crate) const RADIUS: f64 = 0.15;
    /// From wheel to wheel, in metres.
    pub(crate) const TRACK: f64 = 0.3;
    /// Of a wheel at full voltage, in metres per second.
    pub(crate) const FULL_SPEED: f64 = 1.8;
}
