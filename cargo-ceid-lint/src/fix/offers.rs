//! The fixes that the findings of a report offer.

use std::collections::BTreeSet;

use super::{Edit, Fix};
use crate::diagnostic::{Applicability, Diagnostic, Suggestion};
use crate::pipeline::Report;
use crate::source::Span;

/// What the findings offer that `is_wanted`: the first suggestion of each that can be applied by machine, or that a person has to
/// look at if `with_unsafe`. What is suppressed is meant so.
#[must_use]
pub fn offered(report: &Report, with_unsafe: bool, is_wanted: impl Fn(&Diagnostic) -> bool) -> Vec<Fix> {
    let is_taken =
        |suggestion: &&Suggestion| with_unsafe || suggestion.applicability == Applicability::MachineApplicable;
    let wanted = report.shown().filter(|finding| is_wanted(finding));
    let chosen = wanted.filter_map(|finding| Some((finding, finding.suggestions.iter().find(is_taken)?)));
    chosen.map(|(finding, suggestion)| fix(report, finding, suggestion)).collect()
}

/// Filters that are updated too often while siblings of theirs are missed, by file, function and name.
///
/// One of the updates was meant for a sibling. Where other code has come to update that one, none of them is known to be too many.
#[derive(Debug)]
pub struct Pasted(BTreeSet<(String, String, String)>);

impl Pasted {
    /// Those that a report tells.
    #[must_use]
    pub fn of(report: &Report) -> Self {
        let named = report.shown().filter(|finding| finding.facts.filters.len() > 1);
        Self(named.filter_map(|finding| key(report, finding)).collect())
    }

    /// Whether a finding of a later report is about one of them, and names no sibling any more.
    #[must_use]
    pub fn has_lost_its_sibling(&self, report: &Report, finding: &Diagnostic) -> bool {
        finding.facts.filters.len() == 1 && key(report, finding).is_some_and(|key| self.0.contains(&key))
    }
}

/// What a finding about repeated updates is about.
fn key(report: &Report, finding: &Diagnostic) -> Option<(String, String, String)> {
    let file = report.sources.file(finding.primary.span.file).name.clone();
    let filter = finding.facts.filters.first().filter(|_| finding.rule == "repeated_update")?;
    Some((file, finding.facts.function.clone(), filter.clone()))
}

fn fix(report: &Report, finding: &Diagnostic, suggestion: &Suggestion) -> Fix {
    let edit = |(span, text): &(Span, String)| Edit {
        path: report.sources.file(span.file).path.clone(),
        start: span.start as usize,
        end: span.end as usize,
        text: text.clone(),
    };
    Fix {
        rule: finding.rule,
        title: suggestion.message.clone(),
        file: report.sources.file(finding.primary.span.file).name.clone(),
        line: report.sources.line(finding.primary.span),
        is_unsafe: suggestion.applicability == Applicability::MaybeIncorrect,
        edits: suggestion.edits.iter().map(edit).collect(),
    }
}
