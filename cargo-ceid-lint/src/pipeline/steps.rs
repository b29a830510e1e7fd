//! How far a run has come, for whoever looks on from another thread. No clock is read here, and nothing waits for the onlooker.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The work of a run, counted in bytes of code: once for parsing them, and once for each part of their analysis.
#[derive(Clone, Debug, Default)]
pub struct Steps(Arc<Counters>);

#[derive(Debug, Default)]
struct Counters {
    expected: AtomicU64,
    done: AtomicU64,
}

impl Steps {
    /// The parts of an analysis after which it is told.
    const PARTS: u64 = 5;

    /// There is so much code, and it is analysed if it can matter.
    pub(super) fn expect(&self, bytes: u64, can_matter: bool) {
        let times = if can_matter { 1 + Self::PARTS } else { 1 };
        self.0.expected.fetch_add(bytes * times, Ordering::Relaxed);
    }

    /// So much of the code was parsed, or went through a part of the analysis.
    pub(super) fn add(&self, bytes: u64) {
        self.0.done.fetch_add(bytes, Ordering::Relaxed);
    }

    /// How much of the work is done, from 0 to 1.
    #[must_use]
    pub fn share(&self) -> f64 {
        let expected = self.0.expected.load(Ordering::Relaxed);
        let done = self.0.done.load(Ordering::Relaxed).min(expected);
        if expected == 0 { 0.0 } else { done as f64 / expected as f64 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn share_never_leaves_its_bounds() {
        let steps = Steps::default();
        assert!(steps.share() <= 0.0);
        steps.expect(10, true);
        steps.expect(40, false);
        steps.add(50);
        assert!((steps.share() - 0.5).abs() < 1e-9);
        steps.add(1_000);
        assert!(steps.share() <= 1.0);
    }
}
