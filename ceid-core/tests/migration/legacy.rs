//! The loop of the paper's Figure 3, with its two mistakes: one filter is updated twice, the other never.

use super::{Robot, legacy_filters::*};

pub(crate) fn run(robot: &mut Robot) -> (u32, u32) {
    let mut kf = KalmanF::default();
    let mut pf = ParticleF::default();
    loop {
        kf.update();
        // pf.update();
        let Some(position) = robot.env_dependent_transaction() else { break };
        kf.measure(position);
        if position < 0.0 {
            continue;
        }
        pf.observe(kf.estimate());
        kf.update();
    }
    (kf.updates, pf.updates)
}
