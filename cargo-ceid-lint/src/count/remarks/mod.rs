//! What further rules say of the pairs of a function: facts that no verdict carries. A pair keeps the verdict of its counts.

mod debug_only;
mod events;
mod rate;
mod siblings;
mod time;

use std::collections::BTreeMap;

use super::analyse::{Context, CycleId, FunctionFacts};
use super::analysis::Analysis;
use super::functions::FunctionKind;
use super::verdict::{Pair, Verdict};
use crate::diagnostic::WitnessStep;
use crate::flow::WaitKind;
use crate::source::Span;

pub(super) use rate::{Steps, period};
pub(super) use time::{Waiting, waiting};

/// A fact about a filter or a cycle that a rule of its own tells.
#[derive(Clone, Debug)]
pub struct Remark {
    /// Index into the project's packages.
    pub package: usize,
    /// Index into the package's targets.
    pub target: usize,
    /// What it is.
    pub fact: Fact,
    /// The filter, as its pair names it; empty for a cycle.
    pub name: String,
    /// The name of its type.
    pub filter_type: String,
    /// The verdict of the pair, if there is one.
    pub verdict: Option<Verdict>,
    /// The counts of the pair.
    pub counts: Vec<u8>,
    /// Where it is shown.
    pub span: Span,
    /// What leads there.
    pub witness: Vec<WitnessStep>,
    /// The head of the cycle, if it has one.
    pub cycle: Option<Span>,
    /// The function.
    pub function: String,
}

/// What a further rule found.
#[derive(Clone, Debug, PartialEq)]
pub enum Fact {
    /// What is shipped does not have this update; `by` is what keeps it back, as the source spells it.
    DebugOnly {
        /// `debug_assert!`, `#[cfg(debug_assertions)]`
        by: String,
    },
    /// Two events of one loop advance a filter whose step is fixed.
    MultiEvent,
    /// The cycle waits, reads a clock or blocks.
    TimeInCycle {
        /// What the call does.
        kind: WaitKind,
        /// What is called.
        what: String,
    },
    /// The step that a filter is made with is not the period of its cycle, both in seconds.
    RateMismatch {
        /// The filter's.
        step: f64,
        /// The cycle's.
        period: f64,
    },
}

impl Fact {
    /// The rule that tells it.
    #[must_use]
    pub fn rule(&self) -> &'static str {
        match self {
            Self::DebugOnly { .. } => "debug_only_update",
            Self::MultiEvent => "multi_event_update",
            Self::TimeInCycle { .. } => "time_in_cycle",
            Self::RateMismatch { .. } => "rate_mismatch",
        }
    }
}

/// Adds what the rules say of a function's pairs, to the pairs and to the analysis.
pub(super) fn add(
    context: &Context<'_>,
    facts: &FunctionFacts<'_>,
    pairs: &mut BTreeMap<CycleId, Vec<Pair>>,
    analysis: &mut Analysis,
) {
    for pair in pairs.iter_mut().filter(|(id, _)| is_migratable(context, facts, **id)).flat_map(|(_, pairs)| pairs) {
        if pair.verdict == Verdict::Once && pair.counts == [1] {
            note(pair, "unguarded_update");
        }
    }
    if facts.kind == FunctionKind::Presumed
        && let Some(own) = pairs.get_mut(&CycleId::Function)
    {
        siblings::add(context, facts, own);
    }
    debug_only::add(context, facts, pairs, analysis);
    events::add(context, facts, pairs, analysis);
    rate::add(context, facts, pairs, analysis);
    time::add(context, facts, pairs, analysis);
}

/// Whether a guard could stand in a cycle: the law of a filter that is made of filters is what a guard runs.
fn is_migratable(context: &Context<'_>, facts: &FunctionFacts<'_>, id: CycleId) -> bool {
    id != CycleId::Function
        || (facts.kind == FunctionKind::Cycle && !super::functions::is_law(context.program.index, facts.graph.function))
}

/// Adds a rule to those that fire on a pair.
pub(super) fn note(pair: &mut Pair, rule: &'static str) {
    if !pair.rules.contains(&rule) {
        pair.rules.push(rule);
        pair.rules.sort_unstable();
    }
}

/// The keyword at the head of a cycle.
fn head(context: &Context<'_>, facts: &FunctionFacts<'_>, id: CycleId) -> Span {
    match id {
        CycleId::Loop(id) => facts.graph.loop_info(id).keyword,
        CycleId::Function => context.program.index.function(facts.graph.function).function.keyword,
    }
}
