//! References of which it is not known what they lead to: filters that were lent in the same function may be what they update.

use std::collections::BTreeMap;

use super::analyse::{Context, CycleId, FunctionFacts};
use super::instances::place_ty;
use super::verdict::{Pair, Verdict};
use crate::flow::{Cause, Effect, Place};
use crate::index::Ty;

/// What a reference of an unknown origin may update is not proved to be updated once, and not refuted.
pub(super) fn settle(context: &Context<'_>, facts: &FunctionFacts<'_>, pairs: &mut BTreeMap<CycleId, Vec<Pair>>) {
    let (index, graph) = (context.program.index, facts.graph);
    if graph.lent_away.is_empty() {
        return;
    }
    let unknown = updated_by_unknown(context, facts);
    if unknown.is_empty() {
        return;
    }
    let lent: Vec<String> = graph.lent_away.iter().map(|place| graph.place_name(index, place)).collect();
    let is_lent = |pair: &Pair| {
        let rest = lent.iter().filter_map(|name| pair.name.strip_prefix(name.as_str()));
        rest.into_iter().any(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
    };
    for pair in pairs.values_mut().flatten().filter(|pair| pair.verdict != Verdict::Repeated && is_lent(pair)) {
        let may_be = |(name, ty): &&(String, String)| *ty == pair.filter_type && !pair.name.starts_with(name.as_str());
        if let Some((name, _)) = unknown.iter().find(may_be) {
            *pair = pair.in_doubt(&Cause::Limit(match name.starts_with('.') {
                true => "what it is lent to may update it again".to_owned(),
                false => format!("`{name}` may lead to it"),
            }));
        }
    }
}

/// The names of references of an unknown origin through which something is updated, with the types of the filters there.
fn updated_by_unknown(context: &Context<'_>, facts: &FunctionFacts<'_>) -> Vec<(String, String)> {
    let (index, graph) = (context.program.index, facts.graph);
    let mut found: Vec<(String, String)> = Vec::new();
    let mut note = |place: &Place| {
        for root in facts.aliases.shared_roots(place).iter() {
            let Some(info) = root.base_var().map(|var| graph.var(var)).filter(|info| info.param.is_none()) else {
                continue;
            };
            let refers = matches!(info.ty, Ty::Ref(..)) || index.refers_to_filters(&info.ty);
            let Some(ty) = place_ty(index, graph, root).filter(|_| refers) else { continue };
            found.push((graph.place_name(index, root), index.type_name(&ty)));
        }
    };
    for node in &graph.nodes {
        match &node.effect {
            Effect::Update(update) => note(&update.place),
            Effect::Call(site) => context.summaries.updates(site).for_each(|place| note(&place)),
            _ => {}
        }
    }
    found
}
