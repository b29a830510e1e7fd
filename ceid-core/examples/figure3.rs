//! The robot of the paper's Figure 3, done right: each filter is updated once per cycle, and nothing in the loop depends on
//! the environment. The robot drives along a line in simulated time, and believes a noisy range finder.
#![expect(clippy::print_stdout, reason = "an example shows its results")]

use ceid_core::prelude::*;

/// Estimates position and speed from noisy positions.
struct KalmanF {
    position: f64,
    speed: f64,
    variance: f64,
    measured: Option<f64>,
}

impl KalmanF {
    fn new() -> Self {
        Self { position: 0.0, speed: 0.0, variance: 1.0, measured: None }
    }

    fn measure(&mut self, position: f64) {
        self.measured = Some(position);
    }
}

impl<R: Rate> SampledFilter<R> for KalmanF {
    fn update(&mut self, tick: Tick<'_, R>) {
        const PROCESS_NOISE: f64 = 0.05;
        const SENSOR_NOISE: f64 = 0.04;
        self.position += self.speed * tick.dt();
        self.variance += PROCESS_NOISE * tick.dt();
        // A measurement counts once: a cycle without a new one predicts only.
        if let Some(measured) = self.measured.take() {
            let gain = self.variance / (self.variance + SENSOR_NOISE);
            self.position += gain * (measured - self.position);
            self.variance *= 1.0 - gain;
        }
    }
}

/// Finds the wall: a few guesses, each pulled towards what the range finder implies.
struct ParticleF {
    walls: [f64; 8],
    implied: f64,
}

impl ParticleF {
    fn new() -> Self {
        Self { walls: core::array::from_fn(|guess| guess as f64), implied: 0.0 }
    }

    fn observe(&mut self, position: f64, range: f64) {
        self.implied = position + range;
    }

    fn wall(&self) -> f64 {
        self.walls.iter().sum::<f64>() / self.walls.len() as f64
    }
}

impl<R: Rate> SampledFilter<R> for ParticleF {
    fn update(&mut self, tick: Tick<'_, R>) {
        const SETTLING_TIME: f64 = 0.2;
        for wall in &mut self.walls {
            *wall += (self.implied - *wall) * tick.dt() / SETTLING_TIME;
        }
    }
}

filters! {
    /// In the order of their update.
    struct Filters @ 1000 Hz {
        kf: KalmanF;
        pf: ParticleF, every 10;
    }
}

assert_updated_once!(Filters, KalmanF);
assert_updated_once!(Filters, ParticleF);

/// The world outside the loop; the range finder is silent now and then.
struct World {
    position: f64,
    noise: u32,
}

impl World {
    const WALL: f64 = 5.0;

    fn drive(&mut self, speed: f64) {
        self.position += speed * <Hz<1000>>::DT;
    }

    fn range(&mut self) -> Option<f64> {
        self.noise = self.noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = f64::from(self.noise >> 16) / 65_536.0 - 0.5;
        (noise < 0.4).then_some(Self::WALL - self.position + 0.2 * noise)
    }
}

fn main() {
    let mut world = World { position: 0.0, noise: 3 };
    let filters = Filters::register(KalmanF::new(), ParticleF::new());
    let mut control = Cyclic::new(filters, Free::<Hz<1000>>::new().take(5_000));

    println!("time [s]  position [m]  believed [m]  wall [m]");
    each_cycle!(f, info in control => {
        let speed = if f.pf.wall() - f.kf.position > 1.0 { 1.0 } else { 0.0 };
        world.drive(speed);
        f.kf.speed = speed;
        if info.n % 500 == 0 {
            println!("{:8.1}  {:12.3}  {:12.3}  {:8.3}", info.release_ns as f64 / 1e9, world.position, f.kf.position, f.pf.wall());
        }
        // The early `continue` that makes a hand-written update law be skipped; here it cannot be.
        let Some(range) = world.range() else { continue };
        f.kf.measure(World::WALL - range);
        f.pf.observe(f.kf.position, range);
    });
}
