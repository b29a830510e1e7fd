//! Loops of which a guard can have some filters only: which ones, so that the program does the same while the others stay.

use std::collections::BTreeSet;

use super::{Partly, Rewrite};
use crate::count::{Cycle, CycleKind, Pair};

/// Of a loop with more filters than this, it is not tried which of them can go.
const MOST_TRIED: usize = 12;

/// Those of the filters that a guard can have while the others stay as they are, with the rewriting; none if there are many.
///
/// The elements of an array go together or not at all.
pub(super) fn partly(
    cycle: &Cycle,
    by_hand: &[&Pair],
    rewrite: impl Fn(&[&Pair]) -> Option<Rewrite>,
) -> Option<Partly> {
    let owner = |pair: &Pair| pair.name.split('[').next().unwrap_or_default().to_owned();
    let owners: BTreeSet<String> = by_hand.iter().map(|pair| owner(pair)).collect();
    let of = |owners: &BTreeSet<&String>| -> Vec<&Pair> {
        by_hand.iter().copied().filter(|pair| owners.contains(&owner(pair))).collect()
    };
    let rewrite = |pairs: &[&Pair]| rewrite(pairs).filter(|rewrite| rewrite.changes.is_empty());
    if cycle.kind == CycleKind::Closure || !(2..=MOST_TRIED).contains(&owners.len()) {
        return None;
    }
    let can_go = |own: &&String| rewrite(&of(&BTreeSet::from([*own]))).is_some();
    let alone: BTreeSet<&String> = owners.iter().filter(can_go).collect();
    let pairs = of(&alone);
    let rewrite = rewrite(&pairs).filter(|_| !alone.is_empty() && alone.len() < owners.len())?;
    let mut filters: Vec<String> = pairs.iter().map(|pair| pair.name.clone()).collect();
    filters.dedup();
    Some(Partly { filters, rewrite })
}
