//! What a way through a function does to one place, as callers see it.

use super::assumed::Assumed;
use super::counts::Count;
use super::gates::{Asks, KeptMode};
use super::given::Given;
use super::returned;
use super::verdict::Gate;
use crate::flow::Cause;

/// One way through a function, as far as one place goes.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Outcome {
    pub(super) count: Count,
    /// How far the state that it gives back is ahead of the one that it was given, if it hands one through.
    pub(super) ahead: Count,
    pub(super) reset: bool,
    /// Whether a reset is behind its last update, so that nothing of that is left: `filter.update(x); if x < 0.0 { filter.reset(); }`.
    pub(super) renewed: bool,
    pub(super) unknown: Option<Cause>,
    /// Whether some update on the way was not a guard's.
    pub(super) direct: bool,
    /// The heads that the result may have on this way: see [`returned`].
    pub(super) returned: returned::Heads,
    /// Why the way does not update, if it does so on purpose.
    pub(super) gate: Option<Gate>,
    /// The states for which it pauses, where its gate is a mode.
    pub(super) modes: Vec<KeptMode>,
    /// The counters and times of the caller's that it is called again with, where its gate is one of these.
    pub(super) recalled: Vec<Given>,
    /// Whether an update failed and left the filter as it was.
    pub(super) attempted: bool,
    /// What the way does not update for, if that is something of the caller's.
    pub(super) asks: Option<Asks>,
    /// With which conditions of the caller's it is taken.
    pub(super) assumed: Assumed,
    /// What is known at its end of conditions of the caller's that it writes.
    pub(super) left: Assumed,
}

impl Outcome {
    /// How far what it gives back is ahead of what it was given by value.
    pub(super) fn total(&self) -> Count {
        self.count.then(self.ahead)
    }

    /// Nothing is known of this way.
    pub(super) fn unknown(cause: Cause) -> Self {
        Self {
            count: Count::Zero,
            ahead: Count::Zero,
            reset: false,
            renewed: false,
            unknown: Some(cause),
            direct: true,
            returned: returned::ANY,
            gate: None,
            modes: Vec::new(),
            recalled: Vec::new(),
            attempted: false,
            asks: None,
            assumed: Assumed::new(),
            left: Assumed::new(),
        }
    }
}
