//! Loops of which a guard can have some filters only: which ones, so that the program does the same while the others stay.

use std::collections::BTreeSet;

use super::{Partly, Reason, Rewrite};
use crate::count::{Cycle, CycleKind, Pair, Verdict};

/// Of a loop with more filters than this, it is not tried which of them can go.
const MOST_TRIED: usize = 12;

/// Those of the filters that a guard can have while the others stay as they are, with the rewriting; none if there are many.
///
/// The elements of an array go together or not at all.
pub(super) fn partly(
    cycle: &Cycle,
    by_hand: &[&Pair],
    rewrite: impl Fn(&[&Pair]) -> Result<Rewrite, Vec<Reason>>,
) -> Option<Partly> {
    let owner = |pair: &Pair| pair.name.split('[').next().unwrap_or_default().to_owned();
    let owners: BTreeSet<String> = by_hand.iter().map(|pair| owner(pair)).collect();
    let of = |owners: &BTreeSet<&String>| -> Vec<&Pair> {
        by_hand.iter().copied().filter(|pair| owners.contains(&owner(pair))).collect()
    };
    let rewrite = |pairs: &[&Pair]| {
        let rewrite = rewrite(pairs)?;
        if rewrite.changes.is_empty() { Ok(rewrite) } else { Err(rewrite.changes) }
    };
    if cycle.kind == CycleKind::Closure || !(2..=MOST_TRIED).contains(&owners.len()) {
        return None;
    }
    let mut reasons = Vec::new();
    let mut alone: BTreeSet<&String> = BTreeSet::new();
    for own in &owners {
        match rewrite(&of(&BTreeSet::from([own]))) {
            Ok(_) => drop(alone.insert(own)),
            Err(of_own) => reasons.extend(of_own),
        }
    }
    let pairs = of(&alone);
    let is_part = !alone.is_empty() && alone.len() < owners.len();
    let rewrite = Some(&pairs).filter(|_| is_part).and_then(|pairs| rewrite(pairs).ok())?;
    reasons.sort_by_key(|reason| reason.span);
    reasons.dedup();
    let mut filters: Vec<String> = pairs.iter().map(|pair| pair.name.clone()).collect();
    filters.dedup();
    Some(Partly { filters, rewrite, reasons })
}

/// Whether a guard has the filter already, or could not have it.
pub(super) fn is_left(pair: &Pair) -> bool {
    matches!(pair.verdict, Verdict::Guarded | Verdict::Gated | Verdict::OnceOrReset | Verdict::PerSample)
}

/// Why a guard does not get such a filter.
pub(super) fn why_left(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Gated => "the loop leaves it out on purpose, and a guard would not",
        Verdict::OnceOrReset => "the loop resets it instead of updating it, and a guard would do both",
        Verdict::PerSample => "the loop updates it for each sample, and a guard would once an iteration",
        _ => "a guard has it already",
    }
}
