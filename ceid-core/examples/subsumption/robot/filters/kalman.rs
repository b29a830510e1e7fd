//! A Kalman filter for something that moves along an axis.

use ceid_core::prelude::*;

/// Estimates position and velocity from noisy positions. The state moves with a nearly constant velocity.
#[derive(Debug)]
pub(crate) struct KalmanF {
    position: f64,
    velocity: f64,
    /// The covariance: of the position, of both, of the velocity.
    covariance: [f64; 3],
    measured: Sample<f64>,
    noise: Noise,
}

/// How much is not known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Noise {
    /// The density of the unknown acceleration, in (m/s²)² per Hz.
    pub(crate) acceleration: f64,
    /// The variance of a measurement, in m².
    pub(crate) measurement: f64,
}

impl KalmanF {
    const UNKNOWN: [f64; 3] = [100.0, 0.0, 1.0];

    pub(crate) fn new(noise: Noise) -> Unregistered<Self> {
        let measured = Sample::new();
        Unregistered::new(Self { position: 0.0, velocity: 0.0, covariance: Self::UNKNOWN, measured, noise })
    }

    /// Hands a measurement to the law. One that is not a number is none: the law then predicts only.
    pub(crate) fn measure(&mut self, position: f64) {
        if position.is_finite() {
            self.measured.put(position);
        }
    }

    /// Forgets the position but not the velocity: after a gap, the next measurement says where it is.
    pub(crate) fn lose_position(&mut self) {
        self.covariance = [Self::UNKNOWN[0], 0.0, self.covariance[2]];
    }

    pub(crate) fn position(&self) -> f64 {
        self.position
    }

    pub(crate) fn velocity(&self) -> f64 {
        self.velocity
    }

    /// How many cycles ago there was a measurement; `None` if there was none yet.
    pub(crate) fn age(&self) -> Option<u32> {
        self.measured.age()
    }
}

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        let dt = tick.dt();
        let [place, both, speed] = self.covariance;
        let acceleration = self.noise.acceleration;
        self.position += self.velocity * dt;
        let place = place + dt * (2.0 * both + dt * speed) + acceleration * dt * dt * dt / 3.0;
        let both = both + dt * speed + acceleration * dt * dt / 2.0;
        let speed = speed + acceleration * dt;
        self.covariance = [place, both, speed];
        let Some(measured) = self.measured.take(&tick) else { return };
        let innovation = measured - self.position;
        let variance = place + self.noise.measurement;
        let (gain, gain_of_velocity) = (place / variance, both / variance);
        self.position += gain * innovation;
        self.velocity += gain_of_velocity * innovation;
        self.covariance = [(1.0 - gain) * place, (1.0 - gain) * both, speed - gain_of_velocity * both];
    }
}
