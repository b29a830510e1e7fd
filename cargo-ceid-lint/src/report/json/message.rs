//! A finding as rustc would print it, and what is ours beyond that under `ceid`.

use serde::Serialize;

use super::Rendered;
use super::span::{JsonSpan, at_start_of, of_span};
use crate::diagnostic::{Applicability, Diagnostic, Problem, Severity, Suggestion};
use crate::report::{Style, short, text};
use crate::source::{SourceMap, Span};

#[derive(Serialize)]
pub(super) struct Message {
    rendered: Option<String>,
    #[serde(rename = "$message_type")]
    message_type: &'static str,
    message: String,
    code: Option<Code>,
    level: &'static str,
    spans: Vec<JsonSpan>,
    children: Vec<Child>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ceid: Option<Ceid>,
}

#[derive(Serialize)]
struct Code {
    code: String,
    explanation: Option<&'static str>,
}

#[derive(Serialize)]
struct Child {
    message: String,
    code: Option<Code>,
    level: &'static str,
    spans: Vec<JsonSpan>,
    children: [(); 0],
    rendered: Option<&'static str>,
}

/// What a program may want to know about a finding that cargo's form has no field for.
#[derive(Serialize)]
struct Ceid {
    rule: String,
    verdict: String,
    counts: Vec<u8>,
    filter: String,
    #[serde(rename = "type")]
    filter_type: String,
    cycle: Option<Place>,
    fingerprint: String,
    suppressed: Option<String>,
    known: bool,
}

#[derive(Serialize)]
struct Place {
    file: String,
    line: u32,
}

pub(super) fn of_diagnostic(
    sources: &SourceMap,
    diagnostic: &Diagnostic,
    fingerprint: String,
    rendered: Rendered,
) -> Message {
    let is_shown = diagnostic.is_shown();
    let code = format!("ceid::{}", diagnostic.rule);
    let facts = &diagnostic.facts;
    let ceid = Ceid {
        rule: code.clone(),
        verdict: facts.verdict.clone(),
        counts: facts.counts.clone(),
        filter: facts.filters.join(", "),
        filter_type: facts.filter_type.clone(),
        cycle: facts.cycle.map(|head| Place { file: sources.file(head.file).name.clone(), line: sources.line(head) }),
        fingerprint,
        suppressed: diagnostic.suppressed.clone(),
        known: diagnostic.known,
    };
    let mut spans = vec![of_span(sources, diagnostic.primary.span, is_shown, Some(&diagnostic.primary.message))];
    for (number, step) in (1..).zip(&diagnostic.witness.steps) {
        spans.push(of_span(sources, step.span, false, Some(&format!("step {number}: {}", step.message))));
    }
    let mut message = Message {
        rendered: None,
        message_type: "diagnostic",
        message: diagnostic.message.clone(),
        code: Some(Code { code, explanation: None }),
        level: "note",
        spans,
        children: Vec::new(),
        ceid: Some(ceid),
    };
    // A reader that does not know of suppressions and baselines shows nothing without a primary place, and has no fix to apply.
    if is_shown {
        message.level = diagnostic.severity().name();
        message.children = children(sources, diagnostic);
        message.rendered = Some(match rendered {
            Rendered::Plain => text::diagnostic(sources, diagnostic, Style::default()),
            Rendered::Ansi => text::diagnostic(sources, diagnostic, Style { color: true, ..Style::default() }),
            Rendered::Short => short::diagnostic(sources, diagnostic),
        });
    }
    message
}

fn children(sources: &SourceMap, diagnostic: &Diagnostic) -> Vec<Child> {
    let mut children: Vec<Child> = Vec::new();
    children.extend(diagnostic.notes.iter().map(|note| child("note", note.clone())));
    children.extend(text::level_note(diagnostic).map(|note| child("note", note)));
    children.extend(diagnostic.helps.iter().map(|help| child("help", help.clone())));
    children.extend(diagnostic.suggestions.iter().map(|it| suggestion(sources, it, diagnostic)));
    children
}

pub(super) fn of_problem(sources: &SourceMap, problem: &Problem, rendered: Rendered) -> Message {
    let span = match problem.span {
        Some(span) => of_span(sources, span, true, None),
        // A message without a place is dropped by editors.
        None => at_start_of(&problem.file),
    };
    let rendered = match rendered {
        Rendered::Plain => text::problem(sources, problem, Style::default()),
        Rendered::Ansi => text::problem(sources, problem, Style { color: true, ..Style::default() }),
        Rendered::Short => short::problem(sources, problem),
    };
    Message {
        rendered: Some(rendered),
        message_type: "diagnostic",
        message: problem.message.clone(),
        code: None,
        level: Severity::Error.name(),
        spans: vec![span],
        children: problem.help.iter().map(|help| child("help", help.clone())).collect(),
        ceid: None,
    }
}

fn child(level: &'static str, message: String) -> Child {
    Child { message, code: None, level, spans: Vec::new(), children: [], rendered: None }
}

/// Editors offer a suggestion where the cursor meets one of its places, so the places of the finding and of its cycle are added as
/// anchors. rust-analyzer looks for all of them in the file of the first.
fn suggestion(sources: &SourceMap, suggestion: &Suggestion, diagnostic: &Diagnostic) -> Child {
    let applicability = match suggestion.applicability {
        Applicability::MachineApplicable => "MachineApplicable",
        Applicability::MaybeIncorrect => "MaybeIncorrect",
    };
    let edits = suggestion.edits.iter();
    let mut spans: Vec<JsonSpan> = edits
        .map(|(span, replacement)| of_span(sources, *span, true, None).suggesting(replacement, applicability))
        .collect();
    let mut places: Vec<Span> = suggestion.edits.iter().map(|(span, _)| *span).collect();
    for anchor in std::iter::once(diagnostic.primary.span).chain(diagnostic.facts.cycle) {
        let is_met = |place: &Span| place.file == anchor.file && place.start <= anchor.end && anchor.start <= place.end;
        if places.first().is_none_or(|first| first.file == anchor.file) && !places.iter().any(is_met) {
            spans.push(of_span(sources, anchor, true, None));
            places.push(anchor);
        }
    }
    Child { spans, ..child("help", suggestion.message.clone()) }
}
