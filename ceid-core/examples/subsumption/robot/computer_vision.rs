//! Sees the goal.

use super::filters::ParticleF;
use super::signals::{Frame, Inside, Motion, Outside};
use super::vector::Vector;
use ceid_core::prelude::*;

filters! {
    pub(crate) struct Filters @ 30 Hz {
        goal: ParticleF;
    }
}

assert_updated_once!(Filters, ParticleF);

/// Tells where on the field the goal is, as long as the camera shows it.
pub(crate) struct ComputerVision<'t> {
    pub(crate) clock: ClockOf<Self>,
    pub(crate) filters: OnlyInCeid<Filters>,
    pub(crate) io: Inside<'t, Motion, Option<Vector>>,
    pub(crate) camera: Outside<'t, (), Frame>,
}

/// For how many cycles the goal is believed to be where it was seen last: half a second.
const PATIENCE: u32 = 15;

pub(crate) fn filters() -> OnlyInCeid<Filters> {
    OnlyInCeid::new(Filters::register(ParticleF::somewhere(Vector::new(0.0, -3.0), Vector::new(8.0, 3.0))))
}

impl RealtimeFunctionality for ComputerVision<'_> {
    type Rate = Hz<30>;

    fn cycle(&mut self, _: CycleInfo) -> Flow {
        let cycle = self.clock.begin_cycle();
        ceid!(cycle => f = self.filters);
        self.io.set_output(f.goal.estimate(PATIENCE));
        let motion = self.io.input().value();
        if let Some(frame) = self.camera.output().fresh() {
            f.goal.see(motion.place_of(frame.goal));
        }
        Flow::Continue
    }
}
