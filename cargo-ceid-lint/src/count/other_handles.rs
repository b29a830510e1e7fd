//! Filters that a cycle seems to miss and may update by another handle to them: what hands one out may have kept a clone.

use super::analyse::{Context, FunctionFacts};
use super::decide::Decision;
use super::handles::{filter_at, is_among, is_shared};
use super::verdict::{Pair, Verdict};
use crate::flow::{Cause, ControlFlowGraph, Effect, Place, Var};
use crate::index::{Index, Ty};

/// The decision on a filter that no path updates, unless it may be one that is updated through another handle.
pub(super) fn in_doubt(
    context: &Context<'_>,
    facts: &FunctionFacts<'_>,
    place: &Place,
    decision: Decision,
) -> Decision {
    let is_missed = decision.verdict == Verdict::Missed;
    match is_missed.then(|| another(context, facts, place)).flatten() {
        Some(cause) => Decision {
            primary: decision.primary,
            counts: decision.counts,
            law: decision.law,
            ..Decision::unproved(cause)
        },
        None => decision,
    }
}

/// Why another handle may lead to a filter, where such handles are cloned.
fn another(context: &Context<'_>, facts: &FunctionFacts<'_>, place: &Place) -> Option<Cause> {
    let (index, graph) = (context.program.index, facts.graph);
    if !is_shared(index, graph, place) {
        return None;
    }
    let filter = &filter_at(index, graph, place);
    let others = || facts.updated.iter().map(|own| &own.place).filter(|other| *other != place);
    let are_one = |other: &&Place| facts.handles.are_one(context, graph, (place, *other), filter);
    let named =
        |other: &Place| Cause::Limit(format!("`{}` may be another handle to it", graph.place_name(index, other)));
    if let Some(other) = others().filter(|other| is_shared(index, graph, other)).find(are_one) {
        return Some(named(other));
    }
    let [first, all] = facts.handles.ways_to(place);
    let is_given = all.iter().any(|origin| is_handed_out(index, graph, origin));
    let is_made_here =
        !is_given && first.iter().all(|origin| origin.base_var().is_some_and(|var| graph.var(var).param.is_none()));
    if is_made_here {
        return None;
    }
    if is_given && is_among(&context.joined.upgraded, filter) {
        return Some(Cause::Limit("a weak handle elsewhere may lead to it".to_owned()));
    }
    let is_other = |other: &&Place| {
        let is_element = other.steps.iter().any(|step| step.key().is_some());
        (is_given || is_element)
            && is_shared(index, graph, other)
            && filter_at(index, graph, other).is_none_or(|other| filter.as_ref().is_none_or(|filter| *filter == other))
    };
    let is_cloned = is_among(&context.joined.cloned, filter);
    others().filter(|_| is_cloned).find(is_other).map(named)
}

/// Whether a place lies in what a call of the analysed code gives, behind a handle that has to be given for that.
fn is_handed_out(index: &Index, graph: &ControlFlowGraph, place: &Place) -> bool {
    let gives = |effect: &Effect| matches!(effect, Effect::Call(site) if place.base_var() == Some(site.result));
    place.base_var().is_some_and(|var| index.may_share_filter(&graph.var(var).ty))
        && graph.nodes.iter().any(|node| gives(&node.effect))
}

/// Whether a variable has the only handle to a filter: it is made here, and nothing else is given it.
pub(super) fn is_only_handle(index: &Index, facts: &FunctionFacts<'_>, var: Var) -> bool {
    let graph = facts.graph;
    if graph.var(var).param.is_some() || !index.is_handle(&graph.var(var).ty) {
        return false;
    }
    // What a lock or cell lends is the filter, and no handle.
    let may_be_handle = |to: Var| {
        let ty = &graph.var(to).ty;
        index.may_share_filter(ty) || matches!(ty.peel(), Ty::Unknown | Ty::Var(_))
    };
    let is_made_here = |origin: &Place| {
        let is_own = origin.base_var().is_some_and(|var| graph.var(var).param.is_none());
        is_own && !is_handed_out(index, graph, origin)
    };
    let [_, all] = facts.handles.ways_to(&Place::var(var));
    !facts.handles.given_from(var).any(may_be_handle) && all.iter().all(is_made_here)
}

impl Pair {
    /// The same, where it is not known whether it is so.
    pub(super) fn in_doubt(&self, cause: &Cause) -> Self {
        Self {
            verdict: Verdict::Unproved,
            gate: None,
            rules: Verdict::Unproved.rule().into_iter().collect(),
            cause: Some(cause.to_string()),
            witness: Vec::new(),
            primary: None,
            through: Vec::new(),
            others: Vec::new(),
            skips: false,
            ..self.clone()
        }
    }
}
