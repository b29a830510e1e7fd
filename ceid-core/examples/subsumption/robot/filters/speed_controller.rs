//! What voltage makes a wheel turn as fast as wanted.

use crate::robot::signals::chassis;
use ceid_core::prelude::*;

/// A proportional and integral controller with feed-forward.
#[derive(Debug)]
pub(crate) struct SpeedController {
    wanted: f64,
    measured: f64,
    integral: f64,
    voltage: f64,
}

impl SpeedController {
    const PROPORTIONAL: f64 = 0.6;
    const INTEGRAL: f64 = 2.0;

    pub(crate) fn new() -> Unregistered<Self> {
        Unregistered::new(Self { wanted: 0.0, measured: 0.0, integral: 0.0, voltage: 0.0 })
    }

    /// Both in metres per second.
    pub(crate) fn follow(&mut self, wanted: f64, measured: f64) {
        (self.wanted, self.measured) = (wanted, measured);
    }

    pub(crate) fn voltage(&self) -> f64 {
        self.voltage
    }
}

impl<R: Rate> SampledFilter<R> for SpeedController {
    fn update(&mut self, tick: Tick<'_, R>) {
        let error = self.wanted - self.measured;
        // The limit keeps it from winding up while the voltage is at its own.
        self.integral = (self.integral + Self::INTEGRAL * error * tick.dt()).clamp(-0.3, 0.3);
        let voltage = self.wanted / chassis::FULL_SPEED + Self::PROPORTIONAL * error + self.integral;
        self.voltage = voltage.clamp(-1.0, 1.0);
    }
}
