//! The changes that would put a finding right, as edits of the text around it. Offers nothing where it is not certain that what is
//! written compiles, where code comes from a macro, and where a comment would be lost.

mod into_loop;
mod loans;
mod name_guard;
mod second_update;
mod sibling;
mod site;
mod words;

use crate::count::{Analysis, Pair};
use crate::diagnostic::{Diagnostic, Suggestion};
use crate::flow::Program;
use site::{Site, Tokens};

/// Adds to each finding the change that would put it right, if there is one. What is suppressed is meant so.
pub fn add(program: &Program<'_>, analysis: &Analysis, findings: &mut [Diagnostic]) {
    let tokens = Tokens::default();
    for finding in findings.iter_mut().filter(|finding| finding.suppressed.is_none()) {
        if let Some(suggestion) = of_finding(program, &tokens, analysis, finding) {
            // The first help says the same without an offer.
            finding.helps.drain(..1.min(finding.helps.len()));
            finding.suggestions.push(suggestion);
        }
    }
}

fn of_finding(program: &Program<'_>, tokens: &Tokens, analysis: &Analysis, finding: &Diagnostic) -> Option<Suggestion> {
    let site = || Site::of(program, tokens, finding.primary.span);
    match finding.rule {
        "guard_dropped_early" => name_guard::suggestion(&site()?, finding.facts.cycle),
        "guard_outside_cycle" => into_loop::suggestion(&site()?, finding.facts.cycle?),
        "repeated_update" => {
            let site = site()?;
            let pair = pair(analysis, finding)?;
            match &finding.facts.filters[1..] {
                [] => second_update::suggestion(&site, pair),
                missed => sibling::suggestion(&site, pair, missed),
            }
        }
        _ => None,
    }
}

/// The pair that a finding about updates is first about.
fn pair<'a>(analysis: &'a Analysis, finding: &Diagnostic) -> Option<&'a Pair> {
    let cycles = analysis.cycles.iter().filter(|cycle| Some(cycle.head) == finding.facts.cycle);
    let mut pairs = cycles.flat_map(|cycle| &cycle.filters);
    pairs.find(|pair| pair.primary == Some(finding.primary.span) && Some(&pair.name) == finding.facts.filters.first())
}
