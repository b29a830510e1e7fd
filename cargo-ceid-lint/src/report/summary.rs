//! What was checked, in one line: how many cycles and filters, and how many of them are proved.

use super::count;
use crate::count::{Verdict, is_guard_rule};
use crate::diagnostic::{Diagnostic, Severity};
use crate::pipeline::Report;

/// The figures of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// How many cycles were found.
    pub cycles: usize,
    /// How many pairs of a cycle and a filter.
    pub filters: usize,
    /// How many of them are right.
    pub proved: usize,
    /// How many of them are wrong.
    pub violated: usize,
    /// How many findings are shown of which no verdict tells: `multi_event_update`, `unregistered_filter`.
    pub others: usize,
    /// How many findings are suppressed, with a reason or without.
    pub suppressed: usize,
    /// How many could not be decided.
    pub unproved: usize,
    /// How many filter types were found.
    pub filter_types: usize,
    /// How many functions were only searched for repetitions, and have none.
    pub presumed: usize,
    /// How many findings decide the exit code.
    pub errors: usize,
    /// How many findings do not.
    pub warnings: usize,
    /// How many files or modules could not be read or parsed.
    pub problems: usize,
}

impl Summary {
    /// Counts what is in a report.
    #[must_use]
    pub fn of(report: &Report) -> Self {
        let mut summary = Self {
            cycles: report.cycles.len(),
            filter_types: report.filter_types,
            presumed: report.presumed,
            problems: report.problems.len(),
            ..Self::default()
        };
        for pair in report.cycles.iter().flat_map(|cycle| &cycle.filters) {
            summary.filters += 1;
            match pair.verdict {
                Verdict::Unproved => summary.unproved += 1,
                _ if pair.is_proved() => summary.proved += 1,
                _ => summary.violated += 1,
            }
        }
        let is_suppressed = |finding: &&Diagnostic| finding.suppressed.is_some();
        summary.suppressed = report.diagnostics.iter().filter(is_suppressed).count();
        for diagnostic in report.shown() {
            summary.others +=
                usize::from(diagnostic.level.severity().is_some() && !is_told_by_verdict(diagnostic.rule));
            match diagnostic.level.severity() {
                Some(Severity::Error) => summary.errors += 1,
                Some(Severity::Warning) => summary.warnings += 1,
                None => {}
            }
        }
        summary
    }

    /// Whether there is no cycle and no filter.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        self.cycles == 0 && self.filter_types == 0
    }

    /// The summary as a sentence without a full stop.
    #[must_use]
    pub fn line(&self) -> String {
        let mut line = format!("checked {} with {}", count(self.cycles, "cycle"), count(self.filters, "filter"));
        if let Some(decided) = ((self.proved + self.violated) * 100).checked_div(self.filters) {
            line += &format!(
                ": {} proved, {} violated, {} unproved ({decided} % decided)",
                self.proved, self.violated, self.unproved
            );
        }
        if self.cycles == 0 && self.presumed > 0 {
            line += &format!(
                "; searched {} that nothing calls for repeated updates only: name what runs once per cycle with \
                 `[[cycle]]` or `// ceid: cycle`",
                count(self.presumed, "function")
            );
        }
        if self.cycles == 0 && self.presumed == 0 && self.filter_types > 0 {
            line += &format!(
                "; found {}, and no loop or cycle function that runs one",
                count(self.filter_types, "filter type")
            );
        }
        if self.others > 0 {
            line += &format!("; {}", count(self.others, "other finding"));
        }
        if self.suppressed > 0 {
            line += &format!("; {} suppressed", count(self.suppressed, "finding"));
        }
        if self.problems > 0 {
            line += &format!("; {} could not be read", count(self.problems, "file"));
        }
        line
    }
}

/// Whether the verdicts of pairs tell of the findings of a rule.
fn is_told_by_verdict(rule: &str) -> bool {
    let is_verdict = matches!(
        rule,
        "missed_update"
            | "repeated_update"
            | "skipped_update"
            | "unproved_update"
            | "gated_update"
            | "unguarded_update"
    );
    is_verdict || rule == "debug_only_update" || is_guard_rule(rule)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;

    #[test]
    fn every_pair_is_counted_once() {
        let summary = Summary::of(&sample::report().1);
        assert_eq!(summary.proved + summary.violated + summary.unproved, summary.filters);
        let line = "checked 2 cycles with 5 filters: 2 proved, 2 violated, 1 unproved (80 % decided); 1 finding suppressed; 2 files could not be read";
        assert_eq!(summary.line(), line);
        assert_eq!((summary.errors, summary.warnings), (1, 1));
    }

    #[test]
    fn an_empty_report_is_nothing() {
        let summary = Summary::of(&Report::default());
        assert!(summary.is_nothing());
        assert_eq!(summary.line(), "checked 0 cycles with 0 filters");
    }

    #[test]
    fn filters_that_nothing_runs_are_told() {
        let summary = Summary { filter_types: 2, ..Summary::default() };
        let line = "checked 0 cycles with 0 filters; found 2 filter types, and no loop or cycle function that runs one";
        assert_eq!(summary.line(), line);
    }

    #[test]
    fn findings_beside_the_verdicts_are_told() {
        let summary = Summary { cycles: 1, filters: 1, proved: 1, others: 1, ..Summary::default() };
        let line = "checked 1 cycle with 1 filter: 1 proved, 0 violated, 0 unproved (100 % decided); 1 other finding";
        assert_eq!(summary.line(), line);
    }

    #[test]
    fn the_last_percent_is_not_rounded_up() {
        let summary = Summary { filters: 1000, proved: 999, unproved: 1, ..Summary::default() };
        assert!(summary.line().contains("(99 % decided)"));
    }
}
