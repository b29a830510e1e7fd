//! GitLab's code quality report: a list of issues, which merge requests show.

use serde::Serialize;

use super::fingerprint::{fingerprints, of_text};
use super::one_line;
use super::repository::{Repository, first_line};
use crate::diagnostic::{Diagnostic, Problem, Severity};
use crate::pipeline::Report;
use crate::project::Project;

#[derive(Serialize)]
struct Issue {
    description: String,
    check_name: String,
    fingerprint: String,
    severity: &'static str,
    location: Location,
}

#[derive(Serialize)]
struct Location {
    path: String,
    lines: Lines,
}

#[derive(Serialize)]
struct Lines {
    begin: u32,
}

/// One issue for each finding that is shown, and for each file that could not be read.
pub(super) fn document(project: &Project, report: &Report) -> String {
    let repository = Repository::around(&project.root);
    let prints = fingerprints(&report.sources, &report.diagnostics);
    let shown = report.diagnostics.iter().zip(prints).filter(|(finding, _)| finding.is_shown());
    let findings = shown.map(|(finding, print)| of_finding(&repository, report, finding, print));
    let problems = report.problems.iter().map(|problem| of_problem(project, &repository, report, problem));
    let issues: Vec<Issue> = findings.chain(problems).collect();
    let mut text = serde_json::to_string_pretty(&issues).expect("strings and numbers are valid JSON");
    text.push('\n');
    text
}

fn of_finding(repository: &Repository, report: &Report, finding: &Diagnostic, fingerprint: String) -> Issue {
    let span = finding.primary.span;
    Issue {
        description: one_line(&finding.message),
        check_name: format!("ceid::{}", finding.rule),
        fingerprint,
        severity: match finding.severity() {
            Severity::Error => "critical",
            Severity::Warning => "minor",
        },
        location: Location {
            path: repository.path(&report.sources.file(span.file).path),
            lines: Lines { begin: first_line(&report.sources, span).line },
        },
    }
}

fn of_problem(project: &Project, repository: &Repository, report: &Report, problem: &Problem) -> Issue {
    let begin = problem.span.map_or(1, |span| report.sources.line(span));
    Issue {
        description: one_line(&format!("ceid-lint cannot check this file: {}", problem.message)),
        check_name: "ceid-lint".to_owned(),
        fingerprint: of_text(&format!("{}\u{1e}{begin}\u{1e}{}", problem.file, problem.message)),
        severity: "blocker",
        location: Location { path: repository.path(&project.root.join(&problem.file)), lines: Lines { begin } },
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use serde_json::Value;

    use super::*;
    use crate::report::sample;

    #[test]
    fn each_finding_is_an_issue_of_its_own() {
        let (project, report) = sample::report();
        let text = document(&project, &report);
        let issues: Vec<Value> = serde_json::from_str(&text).unwrap();
        assert_eq!(issues.len(), report.shown().count() + report.problems.len());
        let prints: BTreeSet<&str> = issues.iter().map(|issue| issue["fingerprint"].as_str().unwrap()).collect();
        assert_eq!(prints.len(), issues.len(), "GitLab folds issues with equal fingerprints into one");
        insta::assert_snapshot!(text);
    }

    #[test]
    fn a_clean_run_is_an_empty_list() {
        assert_eq!(document(&Project::default(), &Report::default()), "[]\n");
    }
}
