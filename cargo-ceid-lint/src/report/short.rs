//! One line a finding: `file:line:column: error[ceid::rule]: message`.

use super::one_line;
use crate::diagnostic::{Diagnostic, Problem};
use crate::source::SourceMap;

/// A finding in one line.
#[must_use]
pub fn diagnostic(sources: &SourceMap, diagnostic: &Diagnostic) -> String {
    let span = diagnostic.primary.span;
    let place = sources.position(span);
    let severity = diagnostic.severity().name();
    let file = &sources.file(span.file).name;
    let (rule, message) = (diagnostic.rule, one_line(&diagnostic.message));
    format!("{file}:{}:{}: {severity}[ceid::{rule}]: {message}\n", place.line, place.column)
}

/// What cannot be read or parsed, in one line.
#[must_use]
pub fn problem(sources: &SourceMap, problem: &Problem) -> String {
    let message = one_line(&problem.message);
    match problem.span.map(|span| sources.position(span)) {
        Some(place) => format!("{}:{}:{}: error: {message}\n", problem.file, place.line, place.column),
        // What belongs to no file of the code says in its message where it is.
        None if problem.file.is_empty() => format!("error: {message}\n"),
        None => format!("{}: error: {message}\n", problem.file),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;

    #[test]
    fn what_belongs_to_no_file() {
        let problem = Problem {
            file: String::new(),
            span: None,
            message: "cannot read it".to_owned(),
            help: None,
            is_error: true,
        };
        assert_eq!(super::problem(&SourceMap::default(), &problem), "error: cannot read it\n");
    }

    #[test]
    fn one_line_each() {
        let (_, report) = sample::report();
        let findings = report.shown().map(|it| diagnostic(&report.sources, it));
        let lines: Vec<String> =
            findings.chain(report.problems.iter().map(|it| problem(&report.sources, it))).collect();
        assert_eq!(lines.concat().lines().count(), report.shown().count() + report.problems.len());
        insta::assert_snapshot!(lines.concat());
    }
}
