//! The same loop with a guard.

use super::{Robot, filters::*};
use ceid_core::prelude::*;

pub(crate) fn run(robot: &mut Robot) -> (u32, u32) {
    let mut kf = KalmanF::default();
    let mut pf = ParticleF::default();
    let mut clock = Free::<Hz<1000>>::new();
    while let Some(cycle) = clock.next_cycle() {
        ceid!(cycle => kf, pf);
        let Some(position) = robot.env_dependent_transaction() else { break };
        kf.measure(position);
        if position < 0.0 {
            continue;
        }
        pf.observe(kf.estimate());
    }
    (kf.updates, pf.updates)
}
