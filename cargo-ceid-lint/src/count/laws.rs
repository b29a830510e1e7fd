//! The names of laws.

use super::instances::place_ty;
use super::search::Search;
use crate::flow::Effect;

/// The name of the law that runs, as the source calls it. What a guard runs has the name by which the filter is known.
pub(super) fn law_name(search: &Search<'_>) -> Option<String> {
    search.updating().iter().find_map(|id| match &search.graph.node(*id).effect {
        Effect::Update(update) if update.given.is_some() => search.method_of_advance(),
        Effect::Update(update) if update.law == search.law && update.run_by.is_guard() => {
            Some(known_name(search).unwrap_or_else(|| update.method.clone()))
        }
        Effect::Update(update) if update.law == search.law => Some(update.method.clone()),
        _ => None,
    })
}

fn known_name(search: &Search<'_>) -> Option<String> {
    let index = search.program.index;
    let ty = place_ty(index, search.graph, search.instance)?;
    let group = index.filter_spec(ty.peel())?.law.get(search.law)?;
    group.methods.first().cloned()
}
