//! Filters whose constant step is not the constant period of their cycle.

use std::collections::{BTreeMap, BTreeSet};

use super::{Fact, Remark, head, note};
use crate::count::analyse::{Context, CycleId, FunctionFacts};
use crate::count::analysis::Analysis;
use crate::count::fields::{FieldKey, field_key};
use crate::count::verdict::{Pair, Verdict};
use crate::diagnostic::WitnessStep;
use crate::flow::{ControlFlowGraph, Effect, LoopId, NodeId, Place, Program, Step, Var, Wait, WaitKind};
use crate::index::FunctionId;

/// By how much two times may differ and still be one.
const TOLERANCE: f64 = 0.01;

/// The constant steps with which filters are made.
#[derive(Debug, Default)]
pub(in crate::count) struct Steps {
    /// Of the filters in a field, if all are made with the same.
    fields: BTreeMap<FieldKey, Option<Step>>,
    /// Of what a function gives back.
    made: BTreeMap<FunctionId, Option<Step>>,
}

impl Steps {
    /// Collects the steps of all functions.
    pub(in crate::count) fn of(program: &Program<'_>, graphs: &[Option<ControlFlowGraph>]) -> Self {
        let mut steps = Self::default();
        for graph in graphs.iter().flatten() {
            for step in graph.steps.values() {
                unite(steps.made.entry(graph.function), *step);
            }
        }
        if steps.made.is_empty() {
            return steps;
        }
        let mut fields = BTreeMap::new();
        for graph in graphs.iter().flatten() {
            for (place, temporary) in given(graph) {
                if let Some(key) = field_key(program.index, graph, place)
                    && let Some(step) = steps.of_result(graph, temporary, 0)
                {
                    unite(fields.entry(key), step);
                }
            }
        }
        Self { fields, ..steps }
    }

    /// The step of a filter at a place.
    fn of_place(&self, program: &Program<'_>, graph: &ControlFlowGraph, place: &Place) -> Option<Step> {
        if !place.steps.is_empty() {
            return *self.fields.get(&field_key(program.index, graph, place)?)?;
        }
        let mut found = given(graph).filter(|(own, _)| *own == place);
        let (_, temporary) = found.next()?;
        // Of two values one may be there at a time.
        if found.next().is_some() { None } else { self.of_result(graph, temporary, 0) }
    }

    /// The step of a new value: its own, or that of the value which a builder's method takes.
    fn of_result(&self, graph: &ControlFlowGraph, var: Var, depth: u32) -> Option<Step> {
        if let Some(step) = graph.steps.get(&var) {
            return Some(*step);
        }
        let site = graph.nodes.iter().find_map(|node| match &node.effect {
            Effect::Call(site) if site.result == var => Some(site),
            _ => None,
        })?;
        let [target] = site.targets.as_slice() else { return None };
        let by_function = || self.made.get(target).copied().flatten();
        let by_builder = || {
            let taken = site.args.first().filter(|arg| !arg.is_shared)?.place.as_ref()?;
            let taken = taken.base_var().filter(|_| taken.steps.is_empty() && depth < 8)?;
            self.of_result(graph, taken, depth + 1)
        };
        by_function().or_else(by_builder)
    }
}

fn unite<K: Ord>(entry: std::collections::btree_map::Entry<'_, K, Option<Step>>, step: Step) {
    let united = entry.or_insert(Some(step));
    if united.is_some_and(|known| !is_same(known.seconds, step.seconds)) {
        *united = None;
    }
}

fn is_same(left: f64, right: f64) -> bool {
    (left - right).abs() <= TOLERANCE * right.abs()
}

/// The places that new values are moved into, with the values.
fn given(graph: &ControlFlowGraph) -> impl Iterator<Item = (&Place, Var)> {
    graph.nodes.iter().filter_map(|node| match &node.effect {
        Effect::Set(set) | Effect::Write(set) => {
            let from = set.from.as_ref().filter(|from| from.steps.is_empty())?;
            Some((&set.place, from.base_var()?))
        }
        _ => None,
    })
}

/// One remark for each filter that is updated once in every round of a loop with a constant period.
pub(super) fn add(
    context: &Context<'_>,
    facts: &FunctionFacts<'_>,
    pairs: &mut BTreeMap<CycleId, Vec<Pair>>,
    analysis: &mut Analysis,
) {
    let graph = facts.graph;
    let index = context.program.index;
    let def = index.function(graph.function);
    let info = index.crate_of(def.module);
    for instance in &facts.updated {
        for id in &instance.loops {
            let name = graph.place_name(index, &instance.place);
            let cycle = CycleId::Loop(*id);
            let own = pairs.get_mut(&cycle).into_iter().flatten();
            let is_paced = |pair: &Pair| {
                matches!(pair.verdict, Verdict::Once | Verdict::Guarded | Verdict::OnceOrReset)
                    && pair.name == name
                    && pair.half == instance.law
            };
            let Some(pair) = own.into_iter().find(|pair| is_paced(pair)) else { continue };
            let Some(wait) = pace(facts, *id) else { continue };
            let Some(period) = wait.period else { continue };
            let Some(step) = context.steps.of_place(context.program, graph, &instance.place) else { continue };
            if is_same(step.seconds, period) || (!step.has_unit && is_other_unit(step.seconds, period)) {
                continue;
            }
            note(pair, "rate_mismatch");
            let head = head(context, facts, cycle);
            let witness = [(head, "the cycle"), (wait.span, "it waits for its next round here")];
            analysis.remarks.push(Remark {
                package: info.package,
                target: info.target,
                fact: Fact::RateMismatch { step: step.seconds, period },
                name,
                filter_type: pair.filter_type.clone(),
                verdict: Some(pair.verdict),
                counts: pair.counts.clone(),
                span: step.span,
                witness: witness.map(|(span, message)| WitnessStep { span, message: message.to_owned() }).to_vec(),
                cycle: Some(head),
                function: index.function_name(graph.function),
            });
        }
    }
}

/// How long a round of a cycle takes, if one call paces it and that is constant.
pub(in crate::count) fn period(facts: &FunctionFacts<'_>, id: CycleId) -> Option<f64> {
    match id {
        CycleId::Loop(id) => pace(facts, id)?.period,
        CycleId::Function => None,
    }
}

/// The call by which a loop is paced: the one ticker that it waits for in every round, or else its one sleep.
fn pace<'g>(facts: &FunctionFacts<'g>, id: LoopId) -> Option<&'g Wait> {
    let graph = facts.graph;
    let of_kind = |kind: WaitKind| {
        graph.waits.iter().filter(move |wait| {
            wait.kind == kind
                && wait.in_loop.is_some_and(|inner| graph.is_within(Some(inner), id))
                && graph.node(wait.node).debug_only.is_none()
        })
    };
    let ticks: Vec<&Wait> = of_kind(WaitKind::Tick).collect();
    let own = match ticks.as_slice() {
        [] if of_kind(WaitKind::Io).next().is_some() => return None,
        [] => of_kind(WaitKind::Sleep).collect(),
        _ => ticks,
    };
    let [wait] = own.as_slice() else { return None };
    (wait.in_loop == Some(id) && !comes_round_without(graph, id, wait.node)).then_some(*wait)
}

/// Whether a round of a loop can come to its end without a node.
fn comes_round_without(graph: &ControlFlowGraph, id: LoopId, node: NodeId) -> bool {
    let head = graph.loop_info(id).head;
    let mut seen = BTreeSet::from([node]);
    let mut open = graph.node(head).next.clone();
    while let Some(at) = open.pop() {
        if at == head {
            return node != head;
        }
        if graph.is_within(graph.node(at).in_loop, id) && seen.insert(at) {
            open.extend(&graph.node(at).next);
        }
    }
    false
}

/// Whether a number without a unit may be the same time in thousandths or millionths.
fn is_other_unit(step: f64, period: f64) -> bool {
    [1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9].iter().any(|unit| is_same(step * unit, period))
}
