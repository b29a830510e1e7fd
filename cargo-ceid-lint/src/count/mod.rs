//! The analysis this tool exists for: how often each cycle updates each filter.

mod verdict;

pub use verdict::{Cycle, CycleKind, Gate, Pair, Verdict};
