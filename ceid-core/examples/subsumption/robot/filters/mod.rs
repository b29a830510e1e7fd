//! The sampled-time filters of the robot: each has a law that must run once per cycle, and none knows who runs it.

mod kalman;
mod mode;
mod odometry;
mod particle;
mod ramp;
mod remembered;
mod speed_controller;

pub(crate) use kalman::{KalmanF, Noise};
pub(crate) use mode::{Mode, ModeMachine, Side, Situation};
pub(crate) use odometry::Odometry;
pub(crate) use particle::ParticleF;
pub(crate) use ramp::Ramp;
pub(crate) use remembered::Remembered;
pub(crate) use speed_controller::SpeedController;
