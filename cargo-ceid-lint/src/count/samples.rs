//! Loops over samples beside updates that the cycle around them runs itself: whether every sample is one of the filter's.

use super::decide::{Decision, decide};
use super::search::{Region, Search};
use super::verdict::Verdict;
use crate::flow::{Caller, LoopId};

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

/// The loops over samples in a cycle, each of which is a cycle of its own.
fn inner<'a>(search: &'a Search<'_>, region: Region) -> impl Iterator<Item = LoopId> + 'a {
    let is_inside = move |id: &LoopId| match region {
        Region::Loop(own) => own != *id && search.graph.is_within(Some(*id), own),
        Region::Function => true,
    };
    search.sample_loops.iter().copied().filter(is_inside)
}
