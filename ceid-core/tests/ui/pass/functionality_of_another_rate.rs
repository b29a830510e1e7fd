//! The same rate for both.
use ceid_core::prelude::*;

struct LowPass {
    input: f64,
    output: f64,
}

impl<R: Rate> SampledFilter<R> for LowPass {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.output += (self.input - self.output) * tick.dt();
    }
}

filters! { struct Filters @ 1000 Hz { speed: LowPass } }

struct Motor {
    clock: ClockOf<Self>,
    filters: OnlyInCeid<Filters>,
}

impl RealtimeFunctionality for Motor {
    type Rate = Hz<1000>;

    fn cycle(&mut self, _: CycleInfo) -> Flow {
        let cycle = self.clock.begin_cycle();
        ceid!(cycle => f = self.filters);
        f.speed.input = 1.0;
        Flow::Continue
    }
}

fn main() {
    let filters = OnlyInCeid::new(Filters::register(LowPass { input: 0.0, output: 0.0 }));
    let mut motor = Motor { clock: Free::new(), filters };
    let _ = motor.cycle(CycleInfo::default());
}
