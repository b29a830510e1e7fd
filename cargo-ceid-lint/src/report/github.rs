//! Workflow commands of GitHub Actions, which show findings on the lines of a change, and the table of a step summary.

use std::fmt::Write;

use super::repository::{LineRange, Repository, first_line};
use super::{Summary, asides, capitalized, count};
use crate::diagnostic::Diagnostic;
use crate::pipeline::Report;
use crate::project::Project;

/// GitHub shows ten annotations of a kind for a step, and drops the others in silence.
const MOST_ANNOTATIONS: usize = 10;
/// A step summary may have 1 MiB; this many rows stay far below.
const MOST_ROWS: usize = 1_000;

/// One command a finding, worst first, and one that says how many more there are.
pub(super) fn annotations(project: &Project, report: &Report) -> String {
    let repository = Repository::around(&project.root);
    let mut text = String::new();
    let problems = report.problems.iter().map(|problem| {
        let place = problem.span.map(|span| first_line(&report.sources, span));
        let path = problem.span.map(|span| report.sources.file(span.file).path.clone());
        let path = path.unwrap_or_else(|| project.root.join(&problem.file));
        let lines = [Some(&problem.message), problem.help.as_ref()].into_iter().flatten().cloned().collect();
        command("error", &repository.path(&path), place, "ceid-lint: cannot be read", lines)
    });
    let findings = worst_first(report).into_iter().map(|diagnostic| annotation(&repository, report, diagnostic));
    let all: Vec<String> = problems.chain(findings).collect();
    for line in all.iter().take(MOST_ANNOTATIONS) {
        text += line;
    }
    if let Some(more) = all.len().checked_sub(MOST_ANNOTATIONS).filter(|more| *more > 0) {
        let message = format!("{more} more, in the log and in the summary of this step");
        let _ = writeln!(text, "::notice title=ceid-lint::{}", escaped(&message));
    }
    text
}

fn worst_first(report: &Report) -> Vec<&Diagnostic> {
    let mut findings: Vec<&Diagnostic> = report.shown().collect();
    findings.sort_by_key(|finding| finding.severity());
    findings
}

fn annotation(repository: &Repository, report: &Report, diagnostic: &Diagnostic) -> String {
    let span = diagnostic.primary.span;
    let steps = (1..).zip(&diagnostic.witness.steps).map(|(number, step)| {
        let file = repository.path(&report.sources.file(step.span.file).path);
        format!("{number}. {file}:{}: {}", report.sources.line(step.span), step.message)
    });
    let helps = diagnostic.helps.iter().map(|help| format!("help: {help}"));
    let lines = [diagnostic.message.clone()].into_iter().chain(steps).chain(helps).collect();
    let severity = diagnostic.severity().name();
    let path = repository.path(&report.sources.file(span.file).path);
    let place = Some(first_line(&report.sources, span));
    command(severity, &path, place, &format!("ceid::{}", diagnostic.rule), lines)
}

fn command(kind: &str, path: &str, place: Option<LineRange>, title: &str, lines: Vec<String>) -> String {
    let mut properties = format!("file={}", escaped_property(path));
    if let Some(LineRange { line, start, end }) = place {
        let _ = write!(properties, ",line={line},endLine={line},col={start},endColumn={end}");
    }
    format!("::{kind} {properties},title={}::{}\n", escaped_property(title), escaped(&lines.join("\n")))
}

fn escaped(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

fn escaped_property(text: &str) -> String {
    escaped(text).replace(':', "%3A").replace(',', "%2C")
}

/// The table for `$GITHUB_STEP_SUMMARY`, in Markdown.
#[must_use]
pub fn step_summary(project: &Project, report: &Report) -> String {
    let repository = Repository::around(&project.root);
    let summary = Summary::of(report);
    let mut text = format!("### ceid-lint\n\n{}.\n", capitalized(&summary.line()));
    for line in asides(report) {
        let _ = writeln!(text, "\n{}.", capitalized(&line));
    }
    let findings = worst_first(report);
    if !findings.is_empty() {
        text += "\n| Level | Rule | Place | Finding |\n| --- | --- | --- | --- |\n";
    }
    for diagnostic in findings.iter().take(MOST_ROWS) {
        let span = diagnostic.primary.span;
        let place = format!("{}:{}", repository.path(&report.sources.file(span.file).path), report.sources.line(span));
        let severity = diagnostic.severity().name();
        let message = in_cell(&diagnostic.message);
        let _ = writeln!(text, "| {severity} | `ceid::{}` | `{}` | {message} |", diagnostic.rule, in_cell(&place));
    }
    if let Some(more) = findings.len().checked_sub(MOST_ROWS).filter(|more| *more > 0) {
        let _ = writeln!(text, "\n… and {}.", count(more, "more finding"));
    }
    if !report.problems.is_empty() {
        let _ = writeln!(text, "\nNot read, {}:\n", count(report.problems.len(), "file"));
    }
    for problem in report.problems.iter().take(MOST_ROWS) {
        let _ = writeln!(text, "- `{}`: {}", problem.file, problem.message.replace('\n', " "));
    }
    text + "\n"
}

fn in_cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;

    #[test]
    fn what_is_not_shown_is_counted() {
        let (project, mut report) = sample::report();
        let text = annotations(&project, &report);
        assert_eq!(text.lines().count(), report.shown().count() + report.problems.len());
        insta::assert_snapshot!(text);
        let one = report.diagnostics[1].clone();
        report.diagnostics.resize(30, one);
        let text = annotations(&project, &report);
        let commands: Vec<&str> = text.lines().collect();
        assert_eq!(commands.len(), MOST_ANNOTATIONS + 1);
        let more = report.shown().count() + report.problems.len() - MOST_ANNOTATIONS;
        assert!(commands[MOST_ANNOTATIONS].contains(&format!("::{more} more")), "{text}");
        let is_error = |line: &&&str| line.starts_with("::error ");
        assert_eq!(commands.iter().filter(is_error).count(), commands.iter().take_while(is_error).count());
    }

    #[test]
    fn what_would_end_a_command_is_escaped() {
        let line = command("error", "a,b:c.rs", None, "x", vec!["50 %".to_owned(), "y::z".to_owned()]);
        assert_eq!(line, "::error file=a%2Cb%3Ac.rs,title=x::50 %25%0Ay::z\n");
    }

    #[test]
    fn the_step_summary_lists_all_findings() {
        let (project, report) = sample::report();
        let text = step_summary(&project, &report);
        assert_eq!(text.matches("| `ceid::").count(), report.shown().count());
        insta::assert_snapshot!(text);
    }
}
