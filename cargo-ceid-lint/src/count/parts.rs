//! Filters inside of a filter, where nothing is known of that: its own law is their cycle, and is judged by itself.

use std::collections::BTreeMap;

use super::analyse::CycleId;
use super::verdict::{Pair, Verdict};

/// Leaves out what is said of the parts of a filter of which nothing is known either, if the same calls run them.
pub(super) fn leave_to_whole(pairs: &mut BTreeMap<CycleId, Vec<Pair>>) {
    for filters in pairs.values_mut() {
        let is_unknown = |pair: &&Pair| pair.verdict == Verdict::Unproved;
        let wholes: Vec<Pair> = filters.iter().filter(is_unknown).cloned().collect();
        let is_part = |pair: &Pair| {
            wholes.iter().any(|whole| {
                let is_inside = pair.name.strip_prefix(&whole.name).is_some_and(|rest| rest.starts_with('.'));
                // Where not even an update of the whole is seen, what its parts are is a guess.
                let is_by_same =
                    || !pair.updates.is_empty() && pair.updates.iter().all(|update| whole.updates.contains(update));
                is_inside && (whole.updates.is_empty() || is_by_same())
            })
        };
        filters.retain(|pair| !is_unknown(&pair) || !is_part(pair));
    }
}
