//! The words of the proof report: verdicts, gates, kinds of cycles, and the pairs that carry them.

use crate::diagnostic::WitnessStep;
pub use crate::flow::CycleKind;
use crate::source::Span;

/// What was decided for one filter in one cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Verdict {
    /// Every completing path updates exactly once, every exiting path at most once.
    Once,
    /// The same, by a guard.
    Guarded,
    /// Paths that do not update reset the filter.
    OnceOrReset,
    /// Once for every sample of a sample loop that lies inside another cycle.
    PerSample,
    /// Once whenever the gate opens.
    Gated,
    /// Owed, and no path updates.
    Missed,
    /// Some path updates twice or more.
    Repeated,
    /// Some completing path neither updates nor resets, and no gate explains it.
    Skipped,
    /// A part that could matter cannot be seen.
    Unproved,
}

impl Verdict {
    /// The word in the proof report.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Once => "once",
            Self::Guarded => "guarded",
            Self::OnceOrReset => "once_or_reset",
            Self::PerSample => "per_sample",
            Self::Gated => "gated",
            Self::Missed => "missed",
            Self::Repeated => "repeated",
            Self::Skipped => "skipped",
            Self::Unproved => "unproved",
        }
    }

    /// The rule that fires on it, if one does.
    #[must_use]
    pub fn rule(self) -> Option<&'static str> {
        match self {
            Self::Missed => Some("missed_update"),
            Self::Repeated => Some("repeated_update"),
            Self::Skipped => Some("skipped_update"),
            Self::Unproved => Some("unproved_update"),
            Self::Gated => Some("gated_update"),
            Self::Once | Self::Guarded | Self::OnceOrReset | Self::PerSample => None,
        }
    }

    /// How much it says against the filter, where several are to be one.
    #[must_use]
    pub fn gravity(self) -> u8 {
        match self {
            Self::Once | Self::Guarded => 0,
            Self::OnceOrReset => 1,
            Self::PerSample => 2,
            Self::Gated => 3,
            Self::Unproved => 4,
            Self::Skipped => 5,
            Self::Missed => 6,
            Self::Repeated => 7,
        }
    }

    /// Whether the pair is proved to be right.
    #[must_use]
    pub fn is_proved(self) -> bool {
        matches!(self, Self::Once | Self::Guarded | Self::OnceOrReset | Self::PerSample | Self::Gated)
    }
}

/// What kind of condition skips on purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Gate {
    /// Decimation by a counter.
    Rate,
    /// Elapsed time.
    Time,
    /// No sample of this filter's own input.
    Sample,
    /// An arm of a choice between events.
    Event,
    /// A latch that opens once.
    Startup,
    /// The next step covers the gap.
    Measured,
    /// A condition that cannot change inside the cycle.
    Config,
    /// A state that is entered or left with a reset.
    Mode,
}

impl Gate {
    /// The word in the proof report.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Rate => "rate",
            Self::Time => "time",
            Self::Sample => "sample",
            Self::Event => "event",
            Self::Startup => "startup",
            Self::Measured => "measured",
            Self::Config => "config",
            Self::Mode => "mode",
        }
    }
}

/// A cycle with every filter that it updates or owes an update.
#[derive(Clone, Debug)]
pub struct Cycle {
    /// Index into the project's packages.
    pub package: usize,
    /// Index into the package's targets.
    pub target: usize,
    /// The loop keyword, the `fn` keyword, or the closure's `|`.
    pub head: Span,
    /// What it is.
    pub kind: CycleKind,
    /// Whether nothing says that it is one but that nothing which was read calls it.
    pub is_presumed: bool,
    /// The function it lies in: `main`, `Robot::run`.
    pub function: String,
    /// How long one of its rounds takes, in seconds, if it waits for the next one in every round and that is constant.
    pub period: Option<f64>,
    /// Its filters in the order of their first appearance.
    pub filters: Vec<Pair>,
}

/// A filter in a cycle.
#[derive(Clone, Debug)]
pub struct Pair {
    /// The instance as the source spells its place: `kf`, `self.axes.roll`, `filters[*]`.
    pub name: String,
    /// The name of its type: `KalmanF`.
    pub filter_type: String,
    /// The method, or the half of the law.
    pub law: String,
    /// The number of the half.
    pub half: usize,
    /// What was decided.
    pub verdict: Verdict,
    /// The sorted set of counts on completing paths, 2 for 'many'.
    pub counts: Vec<u8>,
    /// What skips on purpose, if something does.
    pub gate: Option<Gate>,
    /// The names of the rules that fire on it, whatever their level, without prefix, sorted.
    pub rules: Vec<&'static str>,
    /// Siblings of its type that nothing updates and that have no pair here, because the cycle is only presumed.
    pub left_out: Vec<String>,
    /// Why it cannot be proved.
    pub cause: Option<String>,
    /// The shortest path that shows the verdict; empty if there is nothing to show.
    pub witness: Vec<WitnessStep>,
    /// Where the finding is shown: the second update, the statement that skips, the head of the cycle.
    pub primary: Option<Span>,
    /// The call through which that is another function's, if it is.
    pub through: Vec<Span>,
    /// Further paths that show the verdict, each at another place, the shortest first.
    pub others: Vec<Evidence>,
    /// Whether another path neither updates nor resets the filter without a reason, where one updates it more than once.
    pub skips: bool,
    /// Where the cycle updates it.
    pub updates: Vec<Span>,
    /// The reason of the suppression that hides all that is found on it, if it is hidden; may be empty.
    pub suppressed: Option<String>,
    /// Whether the baseline holds all that is found on it.
    pub known: bool,
}

/// Whether a rule says that a guard is not there for its cycle.
#[must_use]
pub fn is_guard_rule(rule: &str) -> bool {
    matches!(rule, "forgotten_guard" | "guard_dropped_early" | "guard_outside_cycle")
}

impl Pair {
    /// Whether it is proved to be right: its counts are, and its guard is alive to the end of the cycle.
    #[must_use]
    pub fn is_proved(&self) -> bool {
        self.verdict.is_proved() && !self.rules.iter().any(|rule| is_guard_rule(rule))
    }
}

/// A path that shows a verdict.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// Where it is shown.
    pub primary: Span,
    /// The path.
    pub witness: Vec<WitnessStep>,
}
