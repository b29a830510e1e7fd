//! JUnit's XML, which test overviews show: a suite for each package, a case for each filter of each cycle.

use std::collections::BTreeMap;

use quick_junit::{NonSuccessKind, Report as Document, TestCase, TestCaseStatus, TestSuite};

use super::{Style, one_line, text};
use crate::count::{Cycle, Pair, Verdict};
use crate::diagnostic::{Diagnostic, Severity};
use crate::pipeline::{Report, is_about};
use crate::project::Project;

/// A finding at `deny` is a failure, one at `warn` a skipped case, a proved filter a success. What could not be read is an error.
pub(super) fn document(project: &Project, report: &Report) -> String {
    let mut suites: BTreeMap<usize, TestSuite> = BTreeMap::new();
    let mut add = |package: usize, case: TestCase| {
        let name = || project.packages.get(package).map_or("ceid-lint", |package| &package.name);
        suites.entry(package).or_insert_with(|| TestSuite::new(name())).add_test_case(case);
    };
    for finding in report.shown() {
        add(finding.package, of_finding(report, finding));
    }
    for cycle in &report.cycles {
        for pair in &cycle.filters {
            if !report.shown().any(|finding| is_about(finding, cycle, pair)) {
                add(cycle.package, of_pair(report, cycle, pair));
            }
        }
    }
    for problem in &report.problems {
        let mut status = TestCaseStatus::non_success(NonSuccessKind::Error);
        status.set_type("ceid-lint").set_message(one_line(&problem.message));
        status.set_description(text::problem(&report.sources, problem, Style::default()));
        let mut case = TestCase::new("read", status);
        case.set_classname(problem.file.as_str());
        add(usize::MAX, case);
    }
    let mut document = Document::new("ceid-lint");
    document.add_test_suites(suites.into_values());
    document.to_string().expect("text without control characters is valid XML") + "\n"
}

fn of_finding(report: &Report, finding: &Diagnostic) -> TestCase {
    let mut status = match finding.severity() {
        Severity::Error => TestCaseStatus::non_success(NonSuccessKind::Failure),
        Severity::Warning => TestCaseStatus::skipped(),
    };
    let rule = format!("ceid::{}", finding.rule);
    status.set_type(rule.as_str()).set_message(one_line(&finding.message));
    status.set_description(text::diagnostic(&report.sources, finding, Style::default()));
    let head = finding.facts.cycle.unwrap_or(finding.primary.span);
    let about = if finding.facts.filters.is_empty() { rule } else { finding.facts.filters.join(", ") };
    case(report, head, &finding.facts.function, &about, status)
}

fn of_pair(report: &Report, cycle: &Cycle, pair: &Pair) -> TestCase {
    let unchanged = report.unchanged.iter().find(|it| it.findings.iter().any(|finding| is_about(finding, cycle, pair)));
    let why = match (&pair.suppressed, &pair.cause, pair.verdict) {
        (_, Some(cause), Verdict::Unproved) => Some(format!("unproved: {cause}")),
        (Some(reason), ..) => Some(format!("suppressed: {reason}")),
        (None, None, Verdict::Unproved) => Some("unproved".to_owned()),
        (None, ..) if pair.is_proved() => None,
        (None, _, verdict) => Some(format!("{}, which is allowed", verdict.name())),
    };
    let why = match (unchanged, pair.known) {
        (_, true) => Some(format!("{}, which is known", pair.verdict.name())),
        (Some(unchanged), _) => Some(format!("{}, not changed since {}", pair.verdict.name(), unchanged.revision)),
        _ => why,
    };
    let status = why.map_or_else(TestCaseStatus::success, |why| {
        let mut status = TestCaseStatus::skipped();
        status.set_message(one_line(&why));
        status
    });
    case(report, cycle.head, &cycle.function, &pair.name, status)
}

fn case(report: &Report, head: crate::source::Span, function: &str, about: &str, status: TestCaseStatus) -> TestCase {
    let line = report.sources.line(head);
    let mut case = TestCase::new(format!("{function}:{line} {about}").trim_start_matches(':'), status);
    case.set_classname(report.sources.file(head.file).name.as_str());
    case
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Summary, sample};

    #[test]
    fn findings_filters_and_problems_are_all_cases() {
        let (project, report) = sample::report();
        let text = document(&project, &report);
        let read = Document::deserialize_from_str(&text).unwrap();
        let summary = Summary::of(&report);
        assert_eq!((read.failures, read.errors), (summary.errors, summary.problems));
        insta::assert_snapshot!(text);
    }
}
