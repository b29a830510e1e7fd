//! Loops over samples beside updates that the cycle around them runs itself: whether every sample is one of the filter's.

use super::decide::{Decision, decide};
use super::instances::inner as inner_type;
use super::search::{Region, Search};
use super::verdict::Verdict;
use crate::flow::{CallSite, Caller, Cause, Effect, LoopId, Place, Var};

/// What a cycle is whose loop over samples updates more than once for one of them. What a function that is read here runs in loops of
/// its own, its calls tell.
pub(super) fn repeating(search: &Search<'_>, region: Region) -> Option<Decision> {
    let is_own = |id: &LoopId| {
        let info = search.graph.loop_info(*id);
        !info.is_foreign && info.caller == Caller::Code
    };
    let mut inner = inner(search, region).filter(is_own).map(|id| decide(search, Region::Loop(id), false));
    inner.find(|inner| inner.verdict == Verdict::Repeated)
}

/// What a cycle is whose loop over samples skips one of them for no reason that is known. It may still come to one update in all,
/// as where the first sample of some kind is taken and the rest is left; else the sample is skipped.
pub(super) fn skipping(search: &Search<'_>, region: Region, by_framework: bool) -> Option<Decision> {
    let mut inner = inner(search, region).map(|id| decide(search, Region::Loop(id), false));
    let skipped = inner.find(|inner| inner.verdict == Verdict::Skipped)?;
    let in_all = decide(&search.without_samples(), region, by_framework);
    Some(if in_all.verdict == Verdict::Once { in_all } else { skipped })
}

/// The decision of a loop over samples that come to one update each.
pub(super) fn of_loop(search: &Search<'_>, region: Region, decision: Decision) -> Decision {
    let doubt = if let Region::Loop(id) = region { over_filters(search, id) } else { None };
    match doubt {
        Some(cause) => Decision { verdict: Verdict::Unproved, cause: Some(cause), ..decision },
        None => Decision { verdict: Verdict::PerSample, ..decision },
    }
}

/// Why it is not known whether the rounds of a loop are samples of the instance: the loop goes through other filters, or through
/// settings that have their states elsewhere, and the instance is fed with what their laws give, or is such a state. Where these are
/// stages of one sample it has so many updates; where they are sensors, these are samples.
pub(super) fn over_filters(search: &Search<'_>, id: LoopId) -> Option<Cause> {
    let (graph, index) = (search.graph, search.program.index);
    let info = graph.loop_info(id);
    // What has no name counts.
    let is_item = |var: &&Var| !graph.var(**var).name.is_empty() && info.counter.is_none_or(|(own, _)| own != **var);
    let is_filter = |var: &Var| index.law_spec(&inner_type(&graph.var(*var).ty)).is_some();
    let filters: Vec<Var> = info.bound.iter().filter(is_item).copied().filter(is_filter).collect();
    if filters.is_empty() {
        return None;
    }
    let is_bound = |place: &Place| place.base_var().is_some_and(|var| filters.contains(&var));
    let effects = || graph.nodes.iter().filter(|node| graph.is_within(node.in_loop, id)).map(|node| &node.effect);
    let receiver = |site: &CallSite| site.args.first().and_then(|arg| arg.place.clone());
    let given: Vec<Var> = effects()
        .flat_map(|effect| match effect {
            Effect::Update(update) if is_bound(&update.place) => update.into.clone(),
            Effect::Call(site) if site.law_of.is_some() && receiver(site).is_some_and(|place| is_bound(&place)) => {
                site.into.iter().copied().chain([site.result]).collect()
            }
            _ => Vec::new(),
        })
        .collect();
    let from_given = search.aliases.derived_from(&given);
    let is_it = |place: &Place| search.aliases.shared_roots(place).iter().any(|root| root.overlaps(search.instance));
    let is_fed = |effect: &Effect| match effect {
        Effect::Update(update) if is_it(&update.place) => update.fed.iter().any(|var| from_given.contains(*var)),
        Effect::Call(site) => {
            let state = site.law_of.filter(|at| *at > 0).and_then(|at| site.args.get(at)?.place.as_ref());
            state.is_some_and(is_it) && receiver(site).is_some_and(|place| is_bound(&place))
        }
        _ => false,
    };
    effects().any(is_fed).then(|| {
        Cause::Limit("the loop runs other filters, and whether what each gives is a sample is not known".to_owned())
    })
}

/// The loops over samples in a cycle, each of which is a cycle of its own.
fn inner<'a>(search: &'a Search<'_>, region: Region) -> impl Iterator<Item = LoopId> + 'a {
    let is_inside = move |id: &LoopId| match region {
        Region::Loop(own) => own != *id && search.graph.is_within(Some(*id), own),
        Region::Function => true,
    };
    search.sample_loops.iter().copied().filter(is_inside)
}
