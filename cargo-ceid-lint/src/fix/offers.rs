//! The fixes that the findings of a report offer.

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
