//! What the analysis finds out.

use super::remarks::Remark;
use super::verdict::Cycle;
use crate::source::Span;

/// What the analysis found out about a workspace.
#[derive(Debug, Default)]
pub struct Analysis {
    /// The cycles with their pairs.
    pub cycles: Vec<Cycle>,
    /// Filters that no cycle has to do with and that nothing updates.
    pub unregistered: Vec<Unregistered>,
    /// Guards that do not do what they are there for.
    pub guards: Vec<GuardDefect>,
    /// What further rules say of the pairs and cycles.
    pub remarks: Vec<Remark>,
    /// Functions that nothing calls and in which only repetitions are looked for, without one.
    pub presumed: Vec<Presumed>,
}

impl Analysis {
    /// Adds what was found in another function.
    pub(super) fn add(&mut self, other: Self) {
        self.cycles.extend(other.cycles);
        self.unregistered.extend(other.unregistered);
        self.guards.extend(other.guards);
        self.remarks.extend(other.remarks);
        self.presumed.extend(other.presumed);
    }
}

/// A function that reaches filters and may or may not be called once per cycle.
#[derive(Clone, Copy, Debug)]
pub struct Presumed {
    /// Index into the project's packages.
    pub package: usize,
    /// Index into the package's targets.
    pub target: usize,
    /// Its `fn`.
    pub head: Span,
}

/// A filter that is built and then neither registered, updated, moved nor returned.
#[derive(Clone, Debug)]
pub struct Unregistered {
    /// Index into the project's packages.
    pub package: usize,
    /// Index into the package's targets.
    pub target: usize,
    /// The name of the variable.
    pub name: String,
    /// The name of its type.
    pub filter_type: String,
    /// Where it is built.
    pub span: Span,
    /// The function.
    pub function: String,
    /// The cycle that is there beside it, if there is one.
    pub cycle: Option<Span>,
}

/// What is wrong with a guard.
#[derive(Clone, Debug)]
pub struct GuardDefect {
    /// Index into the project's packages.
    pub package: usize,
    /// Index into the package's targets.
    pub target: usize,
    /// The rule: `guard_outside_cycle`, `guard_dropped_early`, `forgotten_guard`.
    pub rule: &'static str,
    /// Where the guard is made.
    pub made: Span,
    /// Where it goes wrong.
    pub span: Span,
    /// What goes wrong there.
    pub what: String,
    /// What it guards as the source spells it, as far as it is known.
    pub names: Vec<String>,
    /// The function.
    pub function: String,
    /// The head of the cycle it belongs to.
    pub cycle: Option<Span>,
}
