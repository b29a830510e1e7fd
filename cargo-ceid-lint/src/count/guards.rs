//! Guards that are not alive to the end of their cycle.

use super::analyse::{Analysis, FunctionFacts, GuardDefect};
use crate::flow::{Effect, LoopId, Program};

/// Finds the defects of a function's guards.
pub(super) fn defects(program: &Program<'_>, facts: &FunctionFacts<'_>, analysis: &mut Analysis) {
    let graph = facts.graph;
    let index = program.index;
    let def = index.function(graph.function);
    let info = index.crate_of(def.module);
    for (number, guard) in (0u32..).zip(&graph.guards).filter(|(_, guard)| guard.destructor.is_none()) {
        let cycle = guard.in_loop.map(|id| graph.loop_info(id).keyword);
        let mut defect = GuardDefect {
            package: info.package,
            target: info.target,
            rule: "",
            made: guard.span,
            span: guard.span,
            what: String::new(),
            names: guard.names.clone(),
            function: index.function_name(graph.function),
            cycle,
        };
        if let Some((span, how)) = &guard.forgotten {
            defect.rule = "forgotten_guard";
            defect.span = *span;
            defect.what.clone_from(how);
            analysis.guards.push(defect);
            continue;
        }
        if let Some((span, how)) = &guard.dropped {
            defect.rule = "guard_dropped_early";
            defect.span = *span;
            defect.what.clone_from(how);
            analysis.guards.push(defect);
            continue;
        }
        // The loop that runs while the guard is alive, and never ends before it.
        let start =
            graph.node_ids().find(|id| matches!(graph.node(*id).effect, Effect::GuardStart(own) if own.0 == number));
        let end = graph
            .node_ids()
            .filter(|id| matches!(graph.node(*id).effect, Effect::GuardEnd(own) if own.0 == number))
            .last();
        let Some(start) = start else { continue };
        let inside = (0u32..).map(LoopId).zip(&graph.loops).find(|(_, own)| {
            own.parent == guard.in_loop && own.is_endless() && own.head > start && end.is_none_or(|end| own.head < end)
        });
        if let Some((_, own)) = inside {
            defect.rule = "guard_outside_cycle";
            defect.cycle = Some(own.keyword);
            analysis.guards.push(defect);
            continue;
        }
        if let Some(early) = ends_in_inner_block(graph, guard, end) {
            defect.rule = "guard_dropped_early";
            defect.span = early;
            defect.what = "the block it is bound in ends here".to_owned();
            analysis.guards.push(defect);
        }
    }
}

/// Where the block of a guard ends, if the cycle goes on behind it.
fn ends_in_inner_block(
    graph: &crate::flow::ControlFlowGraph,
    guard: &crate::flow::GuardInfo,
    end: Option<crate::flow::NodeId>,
) -> Option<crate::source::Span> {
    let end = end?;
    let own = guard.in_loop?;
    // The guard's end leads to the loop's head through nothing that does something.
    let mut at = end;
    for _ in 0..64 {
        let node = graph.node(at);
        let next = node.next.first().copied()?;
        if next == graph.loop_info(own).head {
            return None;
        }
        if !graph.is_within(graph.node(next).in_loop, own) {
            return None;
        }
        match &graph.node(next).effect {
            Effect::Nothing | Effect::GuardEnd(_) | Effect::Set(_) => at = next,
            Effect::Update(update) if update.run_by.is_guard() => at = next,
            _ => return Some(graph.node(end).span),
        }
    }
    None
}
