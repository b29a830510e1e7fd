//! Where the time of a run goes. No clock is read here: whoever wants to know brings one.

use std::collections::BTreeMap;
use std::time::Duration;

/// The time since some moment that stays the same.
pub type Clock = fn() -> Duration;

/// A part of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Which packages there are.
    Project,
    /// Which of them can have to do with a filter.
    Gate,
    /// Reading and parsing.
    Parse,
    /// The names of items, and the directives.
    Index,
    /// The types of expressions.
    Types,
    /// Graphs of functions.
    Flow,
    /// The verdicts.
    Count,
    /// Findings with their words, fixes and plans.
    Findings,
}

impl Stage {
    /// What it is called.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Project => "project",
            Self::Gate => "gate",
            Self::Parse => "parse",
            Self::Index => "index",
            Self::Types => "types",
            Self::Flow => "flow",
            Self::Count => "count",
            Self::Findings => "findings",
        }
    }
}

/// How long each part took.
#[derive(Clone, Debug, Default)]
pub struct Timings(BTreeMap<Stage, Duration>);

impl Timings {
    /// Adds what another part of the run took.
    pub fn add(&mut self, other: &Self) {
        for (stage, time) in &other.0 {
            *self.0.entry(*stage).or_default() += *time;
        }
    }

    /// Each part, in the order in which they run.
    pub fn iter(&self) -> impl Iterator<Item = (Stage, Duration)> + '_ {
        self.0.iter().map(|(stage, time)| (*stage, *time))
    }
}

/// Measures one part after the other, if there is a clock.
#[derive(Debug)]
pub struct Stopwatch {
    clock: Option<Clock>,
    last: Duration,
    timings: Timings,
}

impl Stopwatch {
    /// Begins to measure.
    #[must_use]
    pub fn start(clock: Option<Clock>) -> Self {
        Self { clock, last: clock.map_or(Duration::ZERO, |clock| clock()), timings: Timings::default() }
    }

    /// The time since the last lap went into this part.
    pub fn lap(&mut self, stage: Stage) {
        let Some(clock) = self.clock else { return };
        let now = clock();
        *self.timings.0.entry(stage).or_default() += now.saturating_sub(self.last);
        self.last = now;
    }

    /// What was measured.
    #[must_use]
    pub fn stop(self) -> Timings {
        self.timings
    }
}
