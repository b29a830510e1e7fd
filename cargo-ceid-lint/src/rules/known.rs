//! Findings that somebody has said are known: which of them are hidden, and which suppressions hide nothing.

use std::cell::RefCell;
use std::collections::BTreeSet;

use super::findings::findings;
use crate::count::{Analysis, Pair};
use crate::diagnostic::WitnessStep;
use crate::source::Span;
use crate::suppress::Suppressions;

/// What is known of findings.
#[derive(Debug)]
pub struct Known<'a> {
    /// What comments and attributes say.
    pub(super) suppressions: &'a Suppressions,
    /// The rules that are at `forbid` in a package, where nothing hides what they find.
    forbidden: BTreeSet<(usize, &'static str)>,
    /// The names in suppressions that a finding was found for, whatever its level.
    used: RefCell<BTreeSet<(usize, usize)>>,
}

/// What hides a finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Hidden {
    /// The number of the suppression.
    number: usize,
    /// Why; empty if it does not say.
    pub(super) reason: String,
}

impl<'a> Known<'a> {
    /// What these suppressions hide, but for the rules that are forbidden in a package.
    #[must_use]
    pub fn new(suppressions: &'a Suppressions, forbidden: BTreeSet<(usize, &'static str)>) -> Self {
        Self { suppressions, forbidden, used: RefCell::default() }
    }

    /// Notes for which suppressions something is found, and shows each pair where nothing hides it, if there is such a place, and in
    /// the code that findings are shown in.
    pub fn prepare(&self, analysis: &mut Analysis, is_own: &dyn Fn(Span) -> bool) {
        for cycle in &mut analysis.cycles {
            for pair in &mut cycle.filters {
                let (Some(rule), Some(first)) = (pair.verdict.rule(), pair.primary) else { continue };
                let is_open =
                    |place: Span| self.hides(rule, cycle.package, &[place, cycle.head], calls_of(pair, rule)).is_none();
                let is_first_open = is_open(first);
                let open: Vec<bool> = pair.others.iter().map(|other| is_open(other.primary)).collect();
                if let Some(at) = open.iter().position(|is_open| *is_open).filter(|_| !is_first_open) {
                    let other = pair.others.swap_remove(at);
                    (pair.primary, pair.witness) = (Some(other.primary), other.witness);
                }
                if is_first_open || open.contains(&true) {
                    pair.primary = pair.primary.map(|place| place_here(place, &pair.witness, cycle.head, is_own));
                }
            }
        }
        for remark in &mut analysis.remarks {
            if let Some(head) = remark.cycle {
                remark.span = place_here(remark.span, &remark.witness, head, is_own);
            }
        }
        drop(findings(analysis, self));
    }

    /// What hides a finding of a rule that is shown at one of these places, or is about these calls.
    pub(super) fn hides(&self, rule: &'static str, package: usize, places: &[Span], calls: &[Span]) -> Option<Hidden> {
        let (number, name) = self.suppressions.of(rule, places, calls)?;
        self.used.borrow_mut().insert((number, name));
        if self.forbidden.contains(&(package, rule)) {
            return None;
        }
        let reason = self.suppressions.list[number].said.reason.clone().unwrap_or_default();
        Some(Hidden { number, reason })
    }

    /// Whether a finding was found for a name in a suppression.
    pub(super) fn is_used(&self, number: usize, name: usize) -> bool {
        self.used.borrow().contains(&(number, name))
    }
}

/// Where a finding is shown whose place lies in code that no finding is shown in: at the last step of the way there that does not, which
/// is the call that leads there, or else at the cycle.
fn place_here(place: Span, witness: &[WitnessStep], head: Span, is_own: &dyn Fn(Span) -> bool) -> Span {
    if is_own(place) || !is_own(head) {
        return place;
    }
    let before = witness.iter().take_while(|step| step.span != place);
    before.map(|step| step.span).filter(|span| is_own(*span)).last().unwrap_or(head)
}

/// The calls that a finding on a pair is about wherever it is shown. A repetition is shown at the call that is too much, and is
/// about the call of the function that has both.
pub(super) fn calls_of<'p>(pair: &'p Pair, rule: &str) -> &'p [Span] {
    if rule == "repeated_update" { &pair.through } else { &pair.updates }
}
