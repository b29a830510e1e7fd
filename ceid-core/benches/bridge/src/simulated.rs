//! How much faster than the clock virtual time is.

use crate::{Bar, heading, median, row};
use ceid_core::prelude::*;
use ceid_core::thread::{SimulatedCycleThread, Task, Until};
use std::hint::black_box;
use std::time::{Duration, Instant};

struct LowPass {
    input: f64,
    output: f64,
}

impl<R: Rate> SampledFilter<R> for LowPass {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.output += (self.input - self.output) * tick.dt() / 0.05;
    }
}

/// A functionality with one filter.
struct Filtered<const HZ: u32>(Cyclic<LowPass, Free<Hz<HZ>>>);

impl<const HZ: u32> Filtered<HZ> {
    fn task() -> Task<Self> {
        Task::new("task", Self(Cyclic::new(LowPass { input: 0.0, output: 0.0 }, Free::new())), Overrun::Stop)
    }
}

impl<const HZ: u32> RealtimeFunctionality for Filtered<HZ> {
    type Rate = Hz<HZ>;

    fn cycle(&mut self, _: CycleInfo) -> Flow {
        let Some(mut guard) = self.0.cycle() else { return Flow::Stop };
        let filter = guard.filters();
        filter.input = black_box(1.0);
        Flow::Continue
    }
}

pub(crate) fn table() {
    heading("virtual time, one filter each at 30, 100 and 1000 Hz");
    let simulated = Duration::from_secs(100);
    let ratios = (0..9).map(|_| {
        let (mut vision, mut motor, mut sensors) =
            (Filtered::<30>::task(), Filtered::<100>::task(), Filtered::<1000>::task());
        let begin = Instant::now();
        SimulatedCycleThread::new().run(&mut [&mut vision, &mut motor, &mut sensors], Until::duration(simulated));
        assert_eq!((vision.cycles(), motor.cycles(), sensors.cycles()), (3_000, 10_000, 100_000));
        simulated.as_secs_f64() / begin.elapsed().as_secs_f64()
    });
    let ratio = median(ratios.collect());
    row(
        "virtual time, simulated / wall (median of 9)",
        &format!("100 s / {:.1} ms", 100e3 / ratio),
        ratio,
        Bar::AtLeast(5000.0),
    );
}
