//! Filters with a fixed step that two different events of one loop advance.

use std::collections::{BTreeMap, BTreeSet};

use super::{Fact, Remark, note};
use crate::config::TimeBase;
use crate::count::analyse::{Context, CycleId, FunctionFacts};
use crate::count::analysis::Analysis;
use crate::count::counts::Count;
use crate::count::cycles::Instance;
use crate::count::gates::is_received;
use crate::count::instances::place_ty;
use crate::count::search::{Region, Search};
use crate::count::verdict::Pair;
use crate::diagnostic::WitnessStep;
use crate::flow::{ControlFlowGraph, CycleKind, Effect, LoopId, NodeId, Place, Rounds, SubjectId, Test, takes_step};
use crate::index::{Index, Ty};

/// How many events of a loop are told apart.
const MAX_EVENTS: usize = 64;

/// One remark for each filter and loop, at the second update.
pub(super) fn add(
    context: &Context<'_>,
    facts: &FunctionFacts<'_>,
    pairs: &mut BTreeMap<CycleId, Vec<Pair>>,
    analysis: &mut Analysis,
) {
    let graph = facts.graph;
    let index = context.program.index;
    for instance in &facts.updated {
        let search = context.search(facts, instance);
        for id in &instance.loops {
            let name = graph.place_name(index, &instance.place);
            let own = pairs.get_mut(&CycleId::Loop(*id));
            let own = own.and_then(|own| own.iter_mut().find(|pair| pair.name == name && pair.half == instance.law));
            let Some(pair) = own else { continue };
            let Some((first, second)) = two_events(context, facts, instance, &search, *id) else { continue };
            note(pair, "multi_event_update");
            let def = index.function(graph.function);
            let info = index.crate_of(def.module);
            let step = |span, message: &str| WitnessStep { span, message: message.to_owned() };
            analysis.remarks.push(Remark {
                package: info.package,
                target: info.target,
                fact: Fact::MultiEvent,
                name,
                filter_type: pair.filter_type.clone(),
                verdict: Some(pair.verdict),
                counts: pair.counts.clone(),
                span: graph.node(second.update).span,
                witness: vec![
                    step(graph.loop_info(*id).keyword, "one loop waits for both events"),
                    step(graph.node(first.arm).span, "one event"),
                    step(graph.node(first.update).span, "the update for it"),
                    step(graph.node(second.arm).span, "another event"),
                ],
                cycle: Some(graph.loop_info(*id).keyword),
                function: index.function_name(graph.function),
            });
        }
    }
}

/// An update that only one event leads to.
#[derive(Clone, Copy)]
struct Advance {
    /// The branch that asks for the event.
    arm: NodeId,
    update: NodeId,
}

/// Two updates of an instance that different arms of one choice between events lead to.
fn two_events(
    context: &Context<'_>,
    facts: &FunctionFacts<'_>,
    instance: &Instance,
    search: &Search<'_>,
    id: LoopId,
) -> Option<(Advance, Advance)> {
    let graph = facts.graph;
    let inside = |node: &NodeId| graph.is_within(graph.node(*node).in_loop, id);
    let region = Region::Loop(id);
    let updates: Vec<NodeId> = search.updating().into_iter().filter(inside).collect();
    if updates.len() < 2 || !has_fixed_step(context.program.index, graph, instance) {
        return None;
    }
    let arms: Vec<(NodeId, &Test)> = graph
        .node_ids()
        .filter(inside)
        .filter_map(|node| match &graph.node(node).effect {
            Effect::Branch(test) if is_event(search, region, test) => Some((node, test)),
            _ => None,
        })
        .take(MAX_EVENTS)
        .collect();
    let behind: Vec<[BTreeSet<NodeId>; 2]> = arms
        .iter()
        .map(|(arm, test)| {
            // What an arm asks beside the event, `First(Some(z))`, leads to the next arm, which asks for the event again.
            let asked = [presence_before(graph, test), test.subject];
            let behind = |cut: &[(NodeId, usize)]| {
                let reached = reached_without(graph, id, cut, asked);
                updates.iter().copied().filter(|update| !reached[update.0 as usize]).collect()
            };
            // `Msg::Position(p) | Msg::Fix(p) => …` asks twice, and each answer leads to the same arm.
            let own: Vec<_> = arms
                .iter()
                .map(|(other, _)| *other)
                .filter(|other| graph.node(*other).span == graph.node(*arm).span)
                .map(|other| (other, 0))
                .collect();
            [behind(&own), behind(&[(*arm, 1)])]
        })
        .collect();
    let own_arm = |update: NodeId| (0..arms.len()).rev().find(|at| behind[*at][0].contains(&update));
    for (at, (arm, test)) in arms.iter().enumerate() {
        let is_select = is_select(graph, test);
        for first in &behind[at][0] {
            let second = behind[at][1].iter().find_map(|update| match own_arm(*update) {
                Some(own) if graph.node(arms[own].0).span != graph.node(*arm).span => {
                    Some(Advance { arm: arms[own].0, update: *update })
                }
                // The last arm of a `select!` is the one that is left.
                None if test.about.heads.is_empty() => Some(Advance { arm: *arm, update: *update }),
                _ => None,
            });
            if let Some(second) = second
                && graph.node(second.update).span != graph.node(*first).span
                && (is_select || some_message_does_not(search, region, &arms))
            {
                return Some((Advance { arm: *arm, update: *first }, second));
            }
        }
    }
    None
}

/// Whether a test chooses between events; whether something came at all is no such choice, and neither is what it measures.
fn is_event(search: &Search<'_>, region: Region, test: &Test) -> bool {
    let heads = &test.about.heads;
    if heads.is_empty() {
        return test.about.is_event;
    }
    let is_kind = heads.iter().any(|head| !matches!(head.as_str(), "+" | "-" | "true" | "false"));
    is_kind
        && !test.about.is_comparison
        && (test.about.is_event || is_received(search, region, test) || is_item(search.graph, region, test))
}

/// Whether a test asks about what an endless `for` over a receiver binds.
fn is_item(graph: &ControlFlowGraph, region: Region, test: &Test) -> bool {
    let Region::Loop(id) = region else { return false };
    let info = graph.loop_info(id);
    info.kind == CycleKind::For
        && info.rounds == Rounds::Unbounded
        && info.counter.is_none()
        && test.about.reads.iter().filter_map(Place::base_var).any(|var| info.bound.contains(&var))
}

/// Whether the choice is between sources, not between the messages of one.
fn is_select(graph: &ControlFlowGraph, test: &Test) -> bool {
    let is_name = |name: &String| name.starts_with("select");
    let computed = test.about.reads.iter().filter_map(|place| graph.computed.get(&place.base_var()?));
    test.about.heads.is_empty()
        || test.about.names.iter().any(is_name)
        || computed.flat_map(|computed| &computed.calls).any(is_name)
}

/// Whether some message is not for the filter. Where each one is, the messages are the samples of one source, in several forms.
fn some_message_does_not(search: &Search<'_>, region: Region, arms: &[(NodeId, &Test)]) -> bool {
    let Region::Loop(id) = region else { return false };
    let head = search.graph.loop_info(id).head;
    let starts: Vec<_> = search.entries(id).into_iter().map(|entry| (head, Some(entry))).collect();
    let exploration = search.explore(region, &starts);
    exploration.ends.iter().filter(|end| end.state.count == Count::Zero).any(|end| {
        let path = exploration.path(end.at);
        path.iter().any(|at| arms.iter().any(|(arm, _)| exploration.states[*at].node == *arm))
    })
}

/// Whether something came at all, where the arms ask that together with what it is: `Ok(Event::Gyro(rate)) => …`.
fn presence_before(graph: &ControlFlowGraph, arm: &Test) -> Option<SubjectId> {
    graph.nodes.iter().find_map(|node| match &node.effect {
        Effect::Branch(test) if test.about.is_event && test.about.asks_presence() => {
            test.subject.filter(|_| test.about.names == arm.about.names)
        }
        _ => None,
    })
}

/// The nodes that an iteration reaches without these sides of branches. Each question about one of two subjects has the same answer.
fn reached_without(
    graph: &ControlFlowGraph,
    id: LoopId,
    cut: &[(NodeId, usize)],
    asked: [Option<SubjectId>; 2],
) -> Vec<bool> {
    let head = graph.loop_info(id).head;
    let mut reached = vec![false; graph.nodes.len()];
    let mut seen = BTreeSet::new();
    let mut open = vec![(head, [u32::MAX; 2])];
    while let Some((at, known)) = open.pop() {
        if !seen.insert((at, known)) {
            continue;
        }
        reached[at.0 as usize] = true;
        for (number, next) in graph.node(at).next.iter().enumerate() {
            let mut known = known;
            if let Effect::Branch(test) = &graph.node(at).effect
                && test.subject.is_some()
            {
                let answer = if number == 0 { test.holds } else { test.fails };
                for (known, _) in known.iter_mut().zip(asked).filter(|(_, subject)| *subject == test.subject) {
                    *known &= answer;
                }
            }
            let is_cut = known.contains(&0) || cut.contains(&(at, number));
            if !is_cut && *next != head && graph.is_within(graph.node(*next).in_loop, id) {
                open.push((*next, known));
            }
        }
    }
    reached
}

/// Whether the step of a filter is baked in or absent: its law is not told the time that has passed.
fn has_fixed_step(index: &Index, graph: &ControlFlowGraph, instance: &Instance) -> bool {
    let Some(ty) = place_ty(index, graph, &instance.place) else { return false };
    let Some(spec) = index.filter_spec(&ty) else { return false };
    if let Some(time_base) = spec.time_base {
        return time_base == TimeBase::Fixed;
    }
    let methods = spec.law.iter().flat_map(|group| &group.methods);
    let laws: Vec<_> = methods
        .flat_map(|method| index.methods(&ty, method).into_iter().map(move |owner| (method, owner)))
        .flat_map(|(method, owner)| match (owner.function(), owner.of_trait()) {
            // Of a trait object every known law counts.
            (own, Some(of)) if !matches!(ty, Ty::Adt(..)) => {
                index.implementations(of, method).into_iter().chain(own).collect()
            }
            (own, _) => own.into_iter().collect::<Vec<_>>(),
        })
        .collect();
    !laws.is_empty() && !laws.iter().any(|law| takes_step(index, *law))
}
