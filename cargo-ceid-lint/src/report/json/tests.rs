//! Our messages, read back by the readers that everybody else uses.

use std::collections::HashSet;

use cargo_metadata::Message;
use cargo_metadata::diagnostic::{Applicability, DiagnosticLevel};

use super::*;
use crate::report::sample;

fn parsed(options: Options) -> Vec<Message> {
    let (project, report) = sample::report();
    let text = messages(&project, &report, options);
    let parsed: Vec<Message> = Message::parse_stream(text.as_bytes()).map(Result::unwrap).collect();
    assert!(!parsed.iter().any(|message| matches!(message, Message::TextLine(_))), "{text}");
    parsed
}

fn diagnostics(options: Options) -> Vec<cargo_metadata::diagnostic::Diagnostic> {
    let messages = parsed(options).into_iter();
    messages.filter_map(|it| if let Message::CompilerMessage(it) = it { Some(it.message) } else { None }).collect()
}

#[test]
fn as_many_come_out_as_go_in() {
    let (_, report) = sample::report();
    assert_eq!(diagnostics(Options::default()).len(), report.diagnostics.len() + report.problems.len());
    let without = Options { without_diagnostics: true, ..Options::default() };
    assert!(diagnostics(without).is_empty());
}

#[test]
fn clean_targets_have_an_artifact_and_the_end_comes_last() {
    let messages = parsed(Options { success: true, ..Options::default() });
    let clean: Vec<String> = messages
        .iter()
        .filter_map(|it| if let Message::CompilerArtifact(it) = it { Some(it.target.name.clone()) } else { None })
        .collect();
    assert_eq!(clean, ["clean"]);
    assert!(matches!(messages.last(), Some(Message::BuildFinished(end)) if end.success));
}

#[test]
fn spans_are_whole_and_count_characters() {
    let (_, report) = sample::report();
    let found = &diagnostics(Options::default())[0];
    assert_eq!(found.code.as_ref().unwrap().code, "ceid::repeated_update");
    assert_eq!(found.level, DiagnosticLevel::Error);
    let primary = found.spans.iter().find(|span| span.is_primary).unwrap();
    assert_eq!((primary.file_name.as_str(), primary.line_start), ("demo/src/main.rs", 5));
    for span in &found.spans {
        let lines: Vec<&str> = report.sources.files().next().unwrap().1.text.lines().collect();
        assert_eq!(span.text.len(), span.line_end - span.line_start + 1);
        assert_eq!(span.text[0].text, lines[span.line_start - 1]);
        let shown: String =
            span.text[0].text.chars().skip(span.column_start - 1).take(span.column_end - span.column_start).collect();
        let bytes = &report.sources.files().next().unwrap().1.text[span.byte_start as usize..span.byte_end as usize];
        assert_eq!(shown, bytes);
    }
}

#[test]
fn the_witness_is_secondary_spans_in_order() {
    let found = &diagnostics(Options::default())[0];
    let labels: Vec<&str> =
        found.spans.iter().filter(|span| !span.is_primary).map(|span| span.label.as_deref().unwrap()).collect();
    assert_eq!(
        labels,
        [
            "step 1: the cycle begins here",
            "step 2: first update",
            "step 3: taken when `é > 1.0`",
            "step 4: second update"
        ]
    );
}

#[test]
fn what_is_ours_is_under_its_own_key() {
    let (project, report) = sample::report();
    let text = messages(&project, &report, Options::default());
    let first: Value = serde_json::from_str(text.lines().next().unwrap()).unwrap();
    let mut ceid = first["message"]["ceid"].clone();
    assert_eq!(ceid["fingerprint"].as_str().unwrap().len(), 16);
    ceid.as_object_mut().unwrap().remove("fingerprint");
    assert_eq!(
        ceid,
        serde_json::json!({
            "rule": "ceid::repeated_update", "verdict": "repeated", "counts": [1, 2], "filter": "kf", "type": "KalmanF",
            "cycle": { "file": "demo/src/main.rs", "line": 3 }, "suppressed": null, "known": false,
        })
    );
}

#[test]
fn what_is_suppressed_is_marked_and_nobody_shows_it() {
    let (project, report) = sample::report();
    let text = messages(&project, &report, Options::default());
    let marked = |line: &&str| line.contains("\"suppressed\":\"GPS comes at 5 Hz\"");
    assert_eq!(text.lines().filter(marked).count(), 1);
    let found = &diagnostics(Options::default())[2];
    assert_eq!((found.level, &found.rendered), (DiagnosticLevel::Note, &None));
    assert!(found.children.is_empty() && !found.spans.iter().any(|span| span.is_primary));
    assert_eq!(found.spans[0].line_start, 6);
}

#[test]
fn a_target_with_nothing_but_suppressed_findings_is_clean() {
    let (project, mut report) = sample::report();
    report.diagnostics.retain(|finding| finding.suppressed.is_some());
    report.problems.clear();
    let text = messages(&project, &report, Options::default());
    assert_eq!(text.lines().filter(|line| line.contains("compiler-artifact")).count(), 2);
}

#[test]
fn problems_are_errors_without_a_code() {
    let found = diagnostics(Options::default());
    let problems: Vec<_> = found.iter().filter(|it| it.code.is_none()).collect();
    assert_eq!(problems.len(), 2);
    for problem in problems {
        assert_eq!(problem.level, DiagnosticLevel::Error);
        assert!(problem.spans.iter().any(|span| span.is_primary));
    }
}

#[test]
fn only_the_ansi_form_has_colours() {
    let rendered = |rendered| diagnostics(Options { rendered, ..Options::default() })[0].rendered.clone().unwrap();
    assert!(!rendered(Rendered::Plain).contains('\u{1b}'));
    assert!(rendered(Rendered::Ansi).contains('\u{1b}'));
    assert_eq!(rendered(Rendered::Short).lines().count(), 1);
}

#[test]
fn suggestions_can_be_applied_by_rustfix() {
    let (project, report) = sample::report();
    let text = messages(&project, &report, Options::default());
    let bare: String = text
        .lines()
        .filter_map(|line| {
            let value: Value = serde_json::from_str(line).unwrap();
            (value["reason"] == "compiler-message").then(|| format!("{}\n", value["message"]))
        })
        .collect();
    let all = rustfix::get_suggestions_from_json(&bare, &HashSet::new(), rustfix::Filter::Everything).unwrap();
    assert_eq!(all.len(), 1);
    let safe =
        rustfix::get_suggestions_from_json(&bare, &HashSet::new(), rustfix::Filter::MachineApplicableOnly).unwrap();
    assert!(safe.is_empty());
    let source = &report.sources.files().next().unwrap().1.text;
    let fixed = rustfix::apply_suggestions(source, &all).unwrap();
    assert_eq!(fixed, source.replace("kf.update(); }", "kf.hold(); }"));
    let child = &diagnostics(Options::default())[0].children[2];
    assert_eq!(child.spans[0].suggestion_applicability, Some(Applicability::MaybeIncorrect));
}

#[test]
fn the_whole_message() {
    let (project, report) = sample::report();
    let text = messages(&project, &report, Options { rendered: Rendered::Short, ..Options::default() });
    let first: Value = serde_json::from_str(text.lines().next().unwrap()).unwrap();
    insta::assert_snapshot!(serde_json::to_string_pretty(&first).unwrap());
}
