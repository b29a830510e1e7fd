//! Loops over samples beside updates that the cycle around them runs itself: whether every sample is one of the filter's.

use super::decide::{Decision, decide};
use super::search::{Region, Search};
use super::verdict::Verdict;
use crate::flow::LoopId;

/// What a cycle is whose loop over samples skips one of them for no reason that is known. It may still come to one update in all,
/// as where the first sample of some kind is taken and the rest is left; else the sample is skipped.
pub(super) fn skipping(search: &Search<'_>, region: Region, by_framework: bool) -> Option<Decision> {
    let graph = search.graph;
    let is_inside = |id: LoopId| match region {
        Region::Loop(own) => own != id && graph.is_within(Some(id), own),
        Region::Function => true,
    };
    let inner = search.sample_loops.iter().filter(|id| is_inside(**id));
    let skipped =
        inner.map(|id| decide(search, Region::Loop(*id), false)).find(|inner| inner.verdict == Verdict::Skipped)?;
    let in_all = decide(&search.without_samples(), region, by_framework);
    Some(if in_all.verdict == Verdict::Once { in_all } else { skipped })
}
