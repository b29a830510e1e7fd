//! The changes that would put a finding right, as edits of the text around it. Offers nothing where it is not certain that what is
//! written compiles, where code comes from a macro, and where a comment would be lost.

mod free;
mod into_loop;
mod loans;
mod name_guard;
mod second_update;
mod sibling;
mod site;
mod words;

use std::collections::BTreeMap;

use crate::count::{Analysis, Cycle, Pair};
use crate::diagnostic::{Diagnostic, Suggestion};
use crate::flow::Program;
use crate::source::Span;
use site::{Places, Site};

/// Adds to each finding the change that would put it right, if there is one. What is suppressed is meant so.
pub fn add(program: &Program<'_>, analysis: &Analysis, findings: &mut [Diagnostic]) {
    let places = Places::of(program);
    let mut cycles = Cycles::new();
    for cycle in &analysis.cycles {
        cycles.entry(cycle.head).or_default().push(cycle);
    }
    for finding in findings.iter_mut().filter(|finding| finding.suppressed.is_none()) {
        if let Some(suggestion) = of_finding(&places, &cycles, finding) {
            // The first help says the same without an offer.
            finding.helps.drain(..1.min(finding.helps.len()));
            finding.suggestions.push(suggestion);
        }
    }
}

/// The cycles by their heads.
type Cycles<'a> = BTreeMap<Span, Vec<&'a Cycle>>;

fn of_finding(places: &Places<'_>, cycles: &Cycles<'_>, finding: &Diagnostic) -> Option<Suggestion> {
    let site = || Site::of(places, finding.primary.span);
    match finding.rule {
        "guard_dropped_early" => name_guard::suggestion(&site()?, finding.facts.cycle),
        "guard_outside_cycle" => into_loop::suggestion(&site()?, finding.facts.cycle?),
        "repeated_update" => {
            let site = site()?;
            let pair = pair(cycles, finding)?;
            // What one call updates together has no sibling that was meant.
            let is_repeated =
                |name: &String| own(cycles, finding).any(|own| own.name == *name && own.verdict == pair.verdict);
            match &finding.facts.filters[1..] {
                others if others.iter().any(is_repeated) => None,
                [] => second_update::suggestion(&site, pair),
                missed => sibling::suggestion(&site, pair, missed),
            }
        }
        _ => None,
    }
}

/// The pair that a finding about updates is first about.
fn pair<'a>(cycles: &Cycles<'a>, finding: &Diagnostic) -> Option<&'a Pair> {
    let is_first = |pair: &&Pair| Some(&pair.name) == finding.facts.filters.first();
    own(cycles, finding).find(|pair| pair.primary == Some(finding.primary.span) && is_first(pair))
}

/// The pairs of the cycle that a finding is about.
fn own<'a>(cycles: &Cycles<'a>, finding: &Diagnostic) -> impl Iterator<Item = &'a Pair> {
    let cycles = finding.facts.cycle.and_then(|head| cycles.get(&head));
    let cycles: Vec<&'a Cycle> = cycles.cloned().unwrap_or_default();
    cycles.into_iter().flat_map(|cycle| &cycle.filters)
}
