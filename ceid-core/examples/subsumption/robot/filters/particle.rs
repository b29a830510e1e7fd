//! A particle filter for something that stands still and is often mistaken for something else.

use crate::robot::random::Random;
use crate::robot::vector::Vector;
use ceid_core::prelude::*;

const PARTICLES: usize = 160;

/// Estimates a place from noisy sightings, of which some are of something else.
#[derive(Debug)]
pub(crate) struct ParticleF {
    particles: [Vector; PARTICLES],
    estimate: Vector,
    seen: Sample<Vector>,
    random: Random,
}

impl ParticleF {
    /// How far a particle wanders in each step, and how far a sighting is wrong, in metres.
    const WANDER: f64 = 0.03;
    const SIGHTING: f64 = 0.15;

    /// Knows nothing but that the place is in the rectangle between two corners.
    pub(crate) fn somewhere(from: Vector, to: Vector) -> Unregistered<Self> {
        let mut random = Random::new(1);
        let size = to - from;
        let particles = core::array::from_fn(|_| {
            Vector::new(from.x + size.x * random.uniform(), from.y + size.y * random.uniform())
        });
        Unregistered::new(Self { particles, estimate: from + size * 0.5, seen: Sample::new(), random })
    }

    /// Hands a sighting to the law. One that is not a number is none.
    pub(crate) fn see(&mut self, place: Vector) {
        if place.is_finite() {
            self.seen.put(place);
        }
    }

    /// The place, unless nothing was seen for more than `patience` cycles.
    pub(crate) fn estimate(&self, patience: u32) -> Option<Vector> {
        self.seen.age().filter(|age| *age <= patience).map(|_| self.estimate)
    }

    /// The likelihood has heavy tails, so that a mistaken sighting moves next to nothing.
    fn weight(particle: Vector, seen: Vector) -> f64 {
        let error = particle - seen;
        let weight = 1.0 / (1.0 + error.dot(error) / (Self::SIGHTING * Self::SIGHTING));
        0.001 + weight * weight
    }

    /// As many particles as before, each as often as its weight says (systematic resampling).
    fn resample(&mut self, weights: &[f64; PARTICLES]) {
        let before = self.particles;
        let step = weights.iter().sum::<f64>() / PARTICLES as f64;
        let mut mark = step * self.random.uniform();
        let mut chosen = 0;
        let mut sum = weights[0];
        for particle in &mut self.particles {
            while sum < mark && chosen + 1 < PARTICLES {
                chosen += 1;
                sum += weights[chosen];
            }
            *particle = before[chosen];
            mark += step;
        }
    }
}

impl<R: Rate> SampledFilter<R> for ParticleF {
    fn update(&mut self, tick: Tick<'_, R>) {
        let Some(seen) = self.seen.take(&tick) else { return };
        for particle in &mut self.particles {
            let wander = Vector::new(self.random.normal(), self.random.normal());
            *particle = *particle + wander * Self::WANDER;
        }
        let weights = self.particles.map(|particle| Self::weight(particle, seen));
        self.resample(&weights);
        let sum = self.particles.iter().fold(Vector::default(), |sum, particle| sum + *particle);
        self.estimate = sum * (1.0 / PARTICLES as f64);
    }
}
