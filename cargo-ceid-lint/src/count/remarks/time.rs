//! Cycles that wait, read a clock or block by themselves.

use std::collections::{BTreeMap, BTreeSet};

use super::{Fact, Remark, head};
use crate::count::analyse::{Context, CycleId, FunctionFacts};
use crate::count::analysis::Analysis;
use crate::count::functions::FunctionKind;
use crate::count::verdict::Pair;
use crate::diagnostic::WitnessStep;
use crate::flow::{CallSite, ControlFlowGraph, Effect, NodeId, Program, Rounds, Wait, WaitKind};
use crate::index::{FunctionId, Owner, TraitName};

/// For each function the first call in it that waits, at any depth, in the time of its caller.
pub(in crate::count) type Waiting = BTreeMap<FunctionId, Wait>;

/// Finds the functions that make their callers wait.
pub(in crate::count) fn waiting(program: &Program<'_>, graphs: &[Option<ControlFlowGraph>]) -> Waiting {
    let mut found = Waiting::new();
    let graphs: Vec<&ControlFlowGraph> =
        graphs.iter().flatten().filter(|graph| !is_clock(program, graph.function)).collect();
    loop {
        let before = found.len();
        for graph in &graphs {
            if found.contains_key(&graph.function) {
                continue;
            }
            let own = graph.waits.iter().find(|wait| counts(graph, wait) && is_callers(graph, wait.node));
            let called = || {
                graph.node_ids().filter(|id| is_callers(graph, *id)).find_map(|id| match &graph.node(id).effect {
                    Effect::Call(site) => first_wait(&found, site),
                    _ => None,
                })
            };
            if let Some(wait) = own.or_else(called).cloned() {
                found.insert(graph.function, wait);
            }
        }
        if found.len() == before {
            return found;
        }
    }
}

/// Whether a function belongs to a clock of ceid-core: waiting is what it is for.
fn is_clock(program: &Program<'_>, id: FunctionId) -> bool {
    let index = program.index;
    let def = index.function(id);
    if index.crate_of(def.module).name == "ceid_core" {
        return true;
    }
    let Owner::Impl(of) = def.owner else { return false };
    match &index.impl_def(of).implements {
        Some(TraitName::External(path)) => path.starts_with("ceid_core::") && path.ends_with("::Clock"),
        Some(TraitName::Local(of)) => {
            let of = index.trait_def(*of);
            of.name == "Clock" && index.crate_of(of.module).name == "ceid_core"
        }
        None => false,
    }
}

/// The wait that a call leads to, whatever it runs.
fn first_wait<'w>(waiting: &'w Waiting, site: &CallSite) -> Option<&'w Wait> {
    let first = waiting.get(site.targets.first()?)?;
    site.targets.iter().all(|target| waiting.contains_key(target)).then_some(first)
}

/// Whether a wait is one at all: the tick of something periodic is the cycle's own clock.
fn counts(graph: &ControlFlowGraph, wait: &Wait) -> bool {
    wait.kind != WaitKind::Tick && graph.node(wait.node).debug_only.is_none()
}

/// Whether what happens at a node takes the time of the function's caller, not of an endless loop of its own.
fn is_callers(graph: &ControlFlowGraph, node: NodeId) -> bool {
    graph.node(node).debug_only.is_none()
        && graph.loops_around(node).all(|id| graph.loop_info(id).rounds != Rounds::Unbounded)
}

/// One remark for each call in a cycle that waits.
pub(super) fn add(
    context: &Context<'_>,
    facts: &FunctionFacts<'_>,
    pairs: &BTreeMap<CycleId, Vec<Pair>>,
    analysis: &mut Analysis,
) {
    let graph = facts.graph;
    let index = context.program.index;
    let def = index.function(graph.function);
    let info = index.crate_of(def.module);
    let cycle_of = |in_loop: Option<crate::flow::LoopId>| {
        let around = std::iter::successors(in_loop, |id| graph.loop_info(*id).parent).map(CycleId::Loop);
        let function = (facts.kind == FunctionKind::Cycle).then_some(CycleId::Function);
        around.chain(function).find(|id| pairs.get(id).is_some_and(|pairs| !pairs.is_empty()))
    };
    let mut seen = BTreeSet::new();
    let mut remark = |cycle: CycleId, wait: &Wait, span, through: Option<&str>| {
        if !seen.insert((cycle, span)) {
            return;
        }
        let cycle = head(context, facts, cycle);
        let mut witness = vec![WitnessStep { span: cycle, message: "the cycle".to_owned() }];
        if let Some(call) = through {
            witness.push(WitnessStep { span: wait.span, message: format!("`{call}` leads to `{}`", wait.what) });
        }
        analysis.remarks.push(Remark {
            package: info.package,
            target: info.target,
            fact: Fact::TimeInCycle { kind: wait.kind, what: wait.what.clone() },
            name: String::new(),
            filter_type: String::new(),
            verdict: None,
            counts: Vec::new(),
            span,
            witness,
            cycle: Some(cycle),
            function: index.function_name(graph.function),
        });
    };
    for wait in graph.waits.iter().filter(|wait| counts(graph, wait)) {
        if let Some(cycle) = cycle_of(wait.in_loop) {
            remark(cycle, wait, wait.span, None);
        }
    }
    for id in graph.node_ids() {
        let node = graph.node(id);
        if let Effect::Call(site) = &node.effect
            && node.debug_only.is_none()
            && let Some(cycle) = cycle_of(node.in_loop)
            && let Some(wait) = first_wait(context.waiting, site)
        {
            remark(cycle, wait, node.span, Some(&site.text));
        }
    }
}
