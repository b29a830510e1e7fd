//! From findings to the diagnostics of the protocol.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::client::Client;
use super::documents::{Documents, identity};
use super::protocol::{Diagnostic, Position, Range, RelatedInformation};
use super::view::View;
use crate::diagnostic::{self as found, Problem, Severity};
use crate::pipeline::Report;
use crate::report::text::level_note;
use crate::source::FileId;

/// Who says it.
pub(super) const SOURCE: &str = "ceid-lint";

/// Where an error is shown that is about a file as a whole.
const FIRST_LINE: Range = Range { start: Position { line: 0, character: 0 }, end: Position { line: 0, character: 1 } };

const ERROR: u32 = 1;
const WARNING: u32 = 2;
/// Shown at its place, and in no list: what is known is for whoever works on that line.
const HINT: u32 = 4;

/// What was found, by file. The names of files are relative to the root where they can be.
pub(super) fn of_report(
    report: &Report,
    root: &Path,
    client: &Client,
    documents: &Documents,
) -> BTreeMap<PathBuf, Vec<Diagnostic>> {
    let mut all: BTreeMap<PathBuf, Vec<Diagnostic>> = BTreeMap::new();
    let mut by_file: BTreeMap<FileId, (View<'_>, Vec<Diagnostic>)> = BTreeMap::new();
    let mut add = |file: FileId, read: &dyn Fn(&View<'_>) -> Diagnostic| {
        let new = || (View::new(report, file, client, documents), Vec::new());
        let (view, diagnostics) = by_file.entry(file).or_insert_with(new);
        diagnostics.push(read(view));
    };
    for finding in report.diagnostics.iter().filter(|finding| finding.suppressed.is_none()) {
        add(finding.primary.span.file, &|view| of_finding(view, finding));
    }
    for problem in &report.problems {
        match problem.span {
            Some(span) => add(span.file, &|view| of_problem(problem, view.range(span))),
            None => {
                let path = identity(&root.join(&problem.file));
                all.entry(path).or_default().push(of_problem(problem, FIRST_LINE));
            }
        }
    }
    for (view, diagnostics) in by_file.into_values() {
        all.entry(view.path).or_default().extend(diagnostics);
    }
    all
}

fn of_finding(view: &View<'_>, finding: &found::Diagnostic) -> Diagnostic {
    let related = steps(view, finding);
    let mut message = finding.message.clone();
    if !view.client.shows_related_information {
        for RelatedInformation { location, message: step } in &related {
            let (file, line) = (location.uri.rsplit('/').next().unwrap_or_default(), location.range.start.line + 1);
            message += &format!("\n{step} ({file}:{line})");
        }
    }
    if finding.known {
        message += "\nnote: this is known: it is in the baseline";
    }
    message.extend(finding.notes.iter().map(|note| format!("\nnote: {note}")));
    message.extend(level_note(finding).map(|note| format!("\nnote: {note}")));
    message.extend(finding.helps.iter().map(|help| format!("\nhelp: {help}")));
    let facts = &finding.facts;
    Diagnostic {
        range: view.range(finding.primary.span),
        severity: match finding.severity() {
            _ if finding.known => HINT,
            Severity::Error => ERROR,
            Severity::Warning => WARNING,
        },
        code: Some(format!("ceid::{}", finding.rule)),
        source: SOURCE,
        message,
        related_information: if view.client.shows_related_information { related } else { Vec::new() },
        data: json!({
            "rule": finding.rule,
            "verdict": facts.verdict,
            "counts": facts.counts,
            "filters": facts.filters,
            "type": facts.filter_type,
        }),
    }
}

/// The steps of the path that proves it, and what is to be seen at the place itself where no step says it.
fn steps(view: &View<'_>, finding: &found::Diagnostic) -> Vec<RelatedInformation> {
    let steps = (1..).zip(&finding.witness.steps);
    let steps = steps.map(|(number, step)| (step.span, format!("step {number}: {}", step.message)));
    let is_told = finding.witness.steps.iter().any(|step| step.span == finding.primary.span);
    let label = &finding.primary.message;
    let own = (!is_told && !label.is_empty()).then(|| (finding.primary.span, label.clone()));
    let related = own.into_iter().chain(steps);
    related.map(|(span, message)| RelatedInformation { location: view.location(span), message }).collect()
}

fn of_problem(problem: &Problem, range: Range) -> Diagnostic {
    let help = problem.help.iter().map(|help| format!("\nhelp: {help}"));
    plain(range, problem.message.clone() + &help.collect::<String>())
}

/// An error that no rule has found.
fn plain(range: Range, message: String) -> Diagnostic {
    Diagnostic {
        range,
        severity: ERROR,
        code: None,
        source: SOURCE,
        message,
        related_information: Vec::new(),
        data: serde_json::Value::Null,
    }
}

/// An error about a file as a whole, shown on its first line.
pub(super) fn of_whole_file(message: String) -> Diagnostic {
    plain(FIRST_LINE, message)
}
