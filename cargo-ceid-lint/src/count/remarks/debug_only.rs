//! Filters that only a debug build updates.

use std::collections::{BTreeMap, BTreeSet};

use super::{Fact, Remark, head, note};
use crate::count::analyse::{Context, CycleId, FunctionFacts, is_debug_only};
use crate::count::analysis::Analysis;
use crate::count::debug_only::{self, DebugUpdate};
use crate::count::functions::FunctionKind;
use crate::count::instances::place_ty;
use crate::count::verdict::{Pair, Verdict};
use crate::diagnostic::WitnessStep;
use crate::index::Ty;

/// One remark for each filter and cycle, at the first update that is not shipped.
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
    let mut seen = BTreeSet::new();
    // No graph tells code that only a release build has, and it may be what the debug build has another way for.
    let has_release_code = || context.program.sources.snippet(facts.body).contains("not(debug_assertions)");
    for DebugUpdate { node, place, law, why } in debug_only::updates(graph, &facts.aliases, context.summaries) {
        let own = facts.updated.iter().find(|instance| instance.place == place && instance.law == law);
        let Some(instance) = own.filter(|_| !is_debug_only(graph, &place)) else { continue };
        let name = graph.place_name(index, &place);
        let is_own = |pair: &Pair| pair.name == name && pair.half == law;
        let around = graph.loops_around(node).map(CycleId::Loop).chain([CycleId::Function]);
        let cycle = around.into_iter().find(|id| pairs.get(id).is_some_and(|own| own.iter().any(is_own)));
        let is_given = place.base_var().is_none_or(|var| graph.var(var).param.is_some());
        if cycle.is_none() && is_given && facts.kind == FunctionKind::Helper && debug_only::is_callers(graph, node) {
            // It is said of the cycles of its callers.
            continue;
        }
        let pair = cycle.and_then(|id| pairs.get_mut(&id)?.iter_mut().find(|pair| is_own(pair)));
        let verdict = pair.as_ref().map(|pair| pair.verdict);
        // Where a release build has an update of its own, each build may have its way. No macro has another way.
        let shipped = || context.search(facts, instance).updating();
        let is_besides =
            || !has_release_code() && cycle.is_some_and(|cycle| debug_only::is_besides(graph, node, &shipped(), cycle));
        let is_alternative =
            verdict.is_some_and(|verdict| !matches!(verdict, Verdict::Missed | Verdict::Skipped)) && !is_besides();
        if (why.by.contains("debug_assertions") && is_alternative) || !seen.insert((cycle, name.clone(), law)) {
            continue;
        }
        let counts = match pair {
            Some(pair) => {
                note(pair, "debug_only_update");
                pair.counts.clone()
            }
            None => Vec::new(),
        };
        analysis.remarks.push(Remark {
            package: info.package,
            target: info.target,
            fact: Fact::DebugOnly { by: why.by },
            name,
            filter_type: index.type_name(&place_ty(index, graph, &place).unwrap_or(Ty::Unknown)),
            verdict,
            counts,
            span: why.span,
            witness: cycle
                .map(|id| WitnessStep { span: head(context, facts, id), message: "the cycle".to_owned() })
                .into_iter()
                .collect(),
            cycle: cycle.map(|id| head(context, facts, id)),
            function: index.function_name(graph.function),
        });
    }
}
