//! Loops over samples beside updates that the cycle around them runs itself: whether every sample is one of the filter's.

use super::decide::{Decision, decide};
use super::search::{Region, Search};
use super::verdict::Verdict;
use crate::flow::LoopId;

/// What a cycle is whose loop over samples updates more than once for one of them.
pub(super) fn repeating(search: &Search<'_>, region: Region) -> Option<Decision> {
    inner(search, region).find(|inner| inner.verdict == Verdict::Repeated)
}

/// What a cycle is whose loop over samples skips one of them for no reason that is known. It may still come to one update in all,
/// as where the first sample of some kind is taken and the rest is left; else the sample is skipped.
pub(super) fn skipping(search: &Search<'_>, region: Region, by_framework: bool) -> Option<Decision> {
    let skipped = inner(search, region).find(|inner| inner.verdict == Verdict::Skipped)?;
    let in_all = decide(&search.without_samples(), region, by_framework);
    Some(if in_all.verdict == Verdict::Once { in_all } else { skipped })
}

/// What the loops over samples in a cycle are, each as the cycle that it is.
fn inner<'a>(search: &'a Search<'_>, region: Region) -> impl Iterator<Item = Decision> + 'a {
    let is_inside = move |id: &&LoopId| match region {
        Region::Loop(own) => own != **id && search.graph.is_within(Some(**id), own),
        Region::Function => true,
    };
    search.sample_loops.iter().filter(is_inside).map(|id| decide(search, Region::Loop(*id), false))
}
