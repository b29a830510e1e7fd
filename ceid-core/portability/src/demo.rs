//! The program that every target runs: filters under a guard, two tasks at their own rates, and values handed between
//! them. Once in virtual time, where every target must compute the same, and once in the time of the target.

use ceid_core::exchange::Latest;
use ceid_core::prelude::*;
use ceid_core::thread::{SimulatedCycleThread, SuperloopCycleThread, Task, Until};
use ceid_core::transaction::{Inside, Outside};
use ceid_core::{Time, TransactionIo};
use core::fmt;
use core::time::Duration;

struct LowPass {
    input: f32,
    output: f32,
    time_constant: f32,
}

impl LowPass {
    const fn new(time_constant: f32) -> Unregistered<Self> {
        Unregistered::new(Self { input: 0.0, output: 0.0, time_constant })
    }
}

impl<R: Rate> SampledFilter<R> for LowPass {
    fn update(&mut self, tick: Tick<'_, R>) {
        self.output += (self.input - self.output) * tick.dt_f32() / self.time_constant;
    }
}

filters! {
    struct Filters @ 100 Hz {
        speed: LowPass;
        mean: LowPass, every 10;
    }
}

/// Follows the speed that the planner wants.
struct Motor<'t> {
    control: Cyclic<Filters, Free<Hz<100>>>,
    io: Inside<'t, f32, f32, Latest>,
    /// Of everything that the filters estimated.
    hash: u64,
}

impl RealtimeFunctionality for Motor<'_> {
    type Rate = Hz<100>;

    fn cycle(&mut self, _: CycleInfo) -> Flow {
        let Some(mut guard) = self.control.cycle() else { return Flow::Stop };
        let f = guard.filters();
        for estimate in [f.speed.output, f.mean.output] {
            // FNV-1a, a word at a time.
            self.hash = (self.hash ^ u64::from(estimate.to_bits())).wrapping_mul(0x0100_0000_01b3);
        }
        self.io.set_output(f.speed.output);
        let Some(wanted) = self.io.input().fresh() else { return Flow::Continue };
        f.speed.input = wanted;
        f.mean.input = f.speed.output;
        Flow::Continue
    }
}

/// Wants another speed whenever the motor is near the last one.
struct Planner<'t> {
    io: Outside<'t, f32, f32, Latest>,
    wanted: f32,
}

impl RealtimeFunctionality for Planner<'_> {
    type Rate = Hz<30>;

    fn cycle(&mut self, _: CycleInfo) -> Flow {
        let speed = self.io.output().value();
        if (speed - self.wanted) * (speed - self.wanted) < 0.01 {
            self.wanted = 1.0 - self.wanted;
        }
        self.io.set_input(self.wanted);
        Flow::Continue
    }
}

/// What the counts and the estimates of a run were.
struct Run {
    cycles: u64,
    missed: u64,
    hash: u64,
}

fn run<T: RealtimeThread>(mut thread: T, duration: Duration) -> Run {
    let mut io = TransactionIo::new(0.0, 0.0);
    let (outside, inside) = io.split();
    let filters = Filters::register(LowPass::new(0.1), LowPass::new(0.5));
    let motor = Motor { control: Cyclic::new(filters, Free::new()), io: inside, hash: 0xcbf2_9ce4_8422_2325 };
    let mut motor = Task::new("motor", motor, Overrun::Skip);
    let mut planner = Task::new("planner", Planner { io: outside, wanted: 1.0 }, Overrun::Skip);
    thread.run(&mut [&mut motor, &mut planner], Until::duration(duration));
    Run {
        cycles: motor.cycles() + planner.cycles(),
        missed: motor.missed() + planner.missed(),
        hash: motor.functionality().hash,
    }
}

/// What is printed: the first two lines are the same on every target.
pub struct Report {
    simulated: Run,
    timed: Run,
}

pub fn report(time: impl Time) -> Report {
    Report {
        simulated: run(SimulatedCycleThread::new(), Duration::from_secs(7)),
        timed: run(SuperloopCycleThread::new(time), Duration::from_secs(1)),
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { simulated, timed } = self;
        writeln!(
            f,
            "virtual time: {} cycles, {} missed, path {:016x}",
            simulated.cycles, simulated.missed, simulated.hash
        )?;
        writeln!(f, "own time: {} releases", timed.cycles + timed.missed)?;
        writeln!(f, "of which missed: {}", timed.missed)
    }
}
