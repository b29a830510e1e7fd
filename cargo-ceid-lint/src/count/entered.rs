//! Loops before which it is decided what their name of a filter means: `let osc = if is_left { &mut self.left } else { &mut self.right };`

use std::collections::BTreeSet;

use super::counts::Count;
use super::decide::{Decision, decide_from};
use super::search::{Region, Search, Start};
use super::verdict::{Gate, Verdict};
use crate::flow::{Effect, LoopId, Place, Var};

/// What a loop is that skips the instance, where it does so only if it is entered with a name that means another filter: for all of
/// its rounds that name means the same. `None` if it is not so.
pub(super) fn with_its_name(
    search: &Search<'_>,
    region: Region,
    by_framework: bool,
    starts: &[Start],
    skipped: &Decision,
) -> Option<Decision> {
    let Region::Loop(id) = region else { return None };
    if starts.len() < 2 || gives_name(search, id, starts) {
        return None;
    }
    let own: Vec<Start> = starts.iter().filter(|start| !is_of_another(search, region, start)).cloned().collect();
    if own.is_empty() || own.len() == starts.len() {
        return None;
    }
    let decision = decide_from(search, region, by_framework, &own);
    let counts = skipped.counts.clone();
    Some(match decision.verdict {
        Verdict::Once | Verdict::Guarded | Verdict::OnceOrReset | Verdict::PerSample => {
            Decision { verdict: Verdict::Gated, gate: Some(Gate::Config), counts, ..decision }
        }
        Verdict::Gated => Decision { counts, ..decision },
        _ => decision,
    })
}

/// Whether a loop itself gives a value to one of the variables by which the instance is known where it is entered.
fn gives_name(search: &Search<'_>, id: LoopId, starts: &[Start]) -> bool {
    let entries = starts.iter().filter_map(|(_, entry)| entry.as_ref());
    let names = entries.flat_map(|entry| &entry.names).filter(|name| name.base != search.instance.base);
    let names: BTreeSet<Var> = names.filter_map(Place::base_var).collect();
    search.graph.nodes.iter().filter(|node| search.graph.is_within(node.in_loop, id)).any(|node| match &node.effect {
        Effect::Set(set) | Effect::Write(set) => {
            set.rebinds && set.place.base_var().is_some_and(|var| names.contains(&var))
        }
        Effect::Unknown { places, .. } => places.iter().filter_map(Place::base_var).any(|var| names.contains(&var)),
        _ => false,
    })
}

/// Whether nothing happens to the instance where a region is entered so.
fn is_of_another(search: &Search<'_>, region: Region, start: &Start) -> bool {
    let found = search.explore(region, std::slice::from_ref(start));
    let mut states = found.ends.iter().map(|end| &end.state);
    !found.limit
        && states.all(|state| state.count == Count::Zero && !state.reset && !state.attempted && state.unknown.is_none())
}
