//! One functionality runs unchanged on all threads, and computes the same.

use crate::{InEveryWorld, counts, run};
use ceid_core::TransactionIo;
use ceid_core::exchange::{Latest, Reading};
use ceid_core::prelude::*;
use ceid_core::thread::{Outcome, Task, Until};
use ceid_core::transaction::Inside;
use core::time::Duration;

struct LowPass {
    input: f64,
    output: f64,
}

impl<R: Rate> SampledFilter<R> for LowPass {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.output += (self.input - self.output) * tick.dt() / 0.05;
    }
}

/// Knows its filter and its input and output, and nothing of threads.
struct Motor<'t> {
    clock: Free<Hz<500>>,
    speed: LowPass,
    io: Inside<'t, f64, f64, Latest>,
}

impl RealtimeFunctionality for Motor<'_> {
    type Rate = Hz<500>;

    fn cycle(&mut self, info: CycleInfo) -> Flow {
        let cycle = self.clock.begin_cycle();
        ceid!(cycle => speed = self.speed);
        if info.n == 0 {
            return Flow::Continue;
        }
        speed.input = self.io.input().value();
        self.io.set_output(speed.output);
        Flow::Continue
    }
}

struct Test;

impl InEveryWorld for Test {
    fn test<T: RealtimeThread>(&self, world: &str, thread: T) {
        let mut io = TransactionIo::<f64, f64, Latest>::new(0.0, 0.0);
        let (mut outside, inside) = io.split();
        outside.set_input(1.0);
        let motor = Motor { clock: Free::new(), speed: LowPass { input: 0.0, output: 0.0 }, io: inside };
        // Whatever the machine does, each release has its cycle.
        let mut motor = Task::new("motor", motor, Overrun::CatchUp { max: u32::MAX });
        run(thread, &mut [&mut motor], Until::duration(Duration::from_millis(100)));
        assert_eq!(counts(&motor), (50, 0, Some(Outcome::Completed)), "{world}");
        let mut expected = 0.0;
        (0..48).for_each(|_| expected += (1.0 - expected) * 0.002 / 0.05);
        assert_eq!(outside.output(), Reading::Fresh(expected), "{world}");
    }
}

#[test]
fn a_functionality_runs_unchanged_in_every_world() {
    Test.run();
}
