//! The clock behind `--timings`.

use std::sync::LazyLock;
use std::time::{Duration, Instant};

use super::args::Talk;
use crate::pipeline::Clock;

static START: LazyLock<Instant> = LazyLock::new(Instant::now);

/// The clock, if somebody asked where the time goes. It begins when it is first read.
pub(super) fn clock(talk: &Talk) -> Option<Clock> {
    talk.timings.is_some().then_some(elapsed)
}

fn elapsed() -> Duration {
    START.elapsed()
}
