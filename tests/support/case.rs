//! Case files: the markers and directives in them, and the comparison with what the program found.

use std::fmt;

use super::program::{Finding, Pair};

/// What a case file expects.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Case {
    /// Line and rule of each marker, in source order.
    pub(crate) markers: Vec<(usize, String)>,
    /// Rules that fire once somewhere in the file.
    pub(crate) anywhere: Vec<String>,
    /// Rules at `allow` that the case switches on.
    pub(crate) warned: Vec<String>,
    /// Pairs that the proof report lists.
    pub(crate) reports: Vec<ReportLine>,
}

/// One `//@ report:` line. `None` stands for `_`: anything will do.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct ReportLine {
    place: CyclePlace,
    kind: String,
    name: Option<String>,
    verdict: String,
    counts: Option<Vec<u64>>,
    gate: Option<String>,
}

#[derive(Debug, PartialEq, Eq)]
enum CyclePlace {
    Line(usize),
    Function(String),
}

impl Case {
    /// Reads the markers and directives of a case file.
    ///
    /// # Errors
    ///
    /// A directive that is not known, a rule that does not exist, a marker that points out of the file, a case that
    /// expects nothing at all or both something and nothing.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let mut case = Self::default();
        let mut is_innocent = false;
        let lines = text.lines().count();
        if !text.starts_with("//! ") {
            return Err("line 1: a case starts with a `//!` sentence that says what it fixes".to_owned());
        }
        for (number, line) in (1..).zip(text.lines()) {
            let fail = |problem: String| format!("line {number}: {problem}");
            if let Some(directive) = line.trim_start().strip_prefix("//@") {
                let directive = directive.trim();
                if directive == "no-findings" {
                    is_innocent = true;
                } else if let Some(rule) = directive.strip_prefix("finds:") {
                    case.anywhere.push(known_rule(rule).map_err(fail)?);
                } else if let Some(rule) = directive.strip_prefix("warn:") {
                    case.warned.push(known_rule(rule).map_err(fail)?);
                } else if let Some(pair) = directive.strip_prefix("report:") {
                    case.reports.push(ReportLine::parse(pair).map_err(fail)?);
                } else {
                    return Err(fail(format!("unknown directive `{directive}`")));
                }
                continue;
            }
            for marker in line.split("//~").skip(1) {
                let rule = marker.trim_start_matches(['^', 'v']);
                let arrows = &marker[..marker.len() - rule.len()];
                let up = arrows.matches('^').count();
                let down = arrows.matches('v').count();
                if up > 0 && down > 0 {
                    return Err(fail("a marker points up or down, not both".to_owned()));
                }
                match (number + down).checked_sub(up) {
                    Some(target @ 1..) if target <= lines => {
                        case.markers.push((target, known_rule(rule).map_err(fail)?));
                    }
                    _ => return Err(fail("the marker points out of the file".to_owned())),
                }
            }
        }
        match (is_innocent, case.markers.is_empty() && case.anywhere.is_empty()) {
            (true, false) => Err("`//@ no-findings` beside an expected finding".to_owned()),
            (false, true) => Err("no expectation: add a marker or `//@ no-findings`".to_owned()),
            _ => Ok(case),
        }
    }
}

fn known_rule(text: &str) -> Result<String, String> {
    let rule = text.trim();
    if super::RULES.contains(&rule) { Ok(rule.to_owned()) } else { Err(format!("unknown rule `{rule}`")) }
}

impl ReportLine {
    fn parse(text: &str) -> Result<Self, String> {
        let any = |word: &str| (word != "_").then(|| word.to_owned());
        let words: Vec<&str> = text.split_whitespace().collect();
        let (&[place, kind, name, verdict, counts], gate) = match words.split_at_checked(5) {
            Some((head, [])) => (head.try_into().expect("five words"), None),
            Some((head, [gate])) => (head.try_into().expect("five words"), Some((*gate).to_owned())),
            _ => {
                return Err(
                    "expected `report: <line-or-function> <kind> <name> <verdict> <counts> [<gate>]`".to_owned()
                );
            }
        };
        let counts = match counts {
            "_" => None,
            list => Some(
                list.split(',')
                    .map(str::parse)
                    .collect::<Result<_, _>>()
                    .map_err(|_| format!("bad counts `{list}`"))?,
            ),
        };
        let place = match place.parse() {
            Ok(line) => CyclePlace::Line(line),
            Err(_) => CyclePlace::Function(place.to_owned()),
        };
        Ok(Self { place, kind: kind.to_owned(), name: any(name), verdict: verdict.to_owned(), counts, gate })
    }

    /// Whether the pair belongs to the same cycle and filter.
    pub(crate) fn is_about(&self, pair: &Pair) -> bool {
        let is_here = match &self.place {
            CyclePlace::Line(line) => *line == pair.line,
            CyclePlace::Function(function) => *function == pair.function,
        };
        is_here || self.name.as_ref().is_some_and(|name| *name == pair.name)
    }

    /// Whether the pair is the expected one.
    pub(crate) fn matches(&self, pair: &Pair) -> bool {
        let is_here = match &self.place {
            CyclePlace::Line(line) => *line == pair.line,
            CyclePlace::Function(function) => *function == pair.function,
        };
        is_here
            && self.kind == pair.kind
            && self.name.as_ref().is_none_or(|name| *name == pair.name)
            && self.verdict == pair.verdict
            && self.counts.as_ref().is_none_or(|counts| *counts == pair.counts)
            && self.gate.as_ref().is_none_or(|gate| Some(gate) == pair.gate.as_ref())
    }
}

impl fmt::Display for ReportLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.place {
            CyclePlace::Line(line) => write!(f, "line {line}, ")?,
            CyclePlace::Function(function) => write!(f, "in {function}, ")?,
        }
        write!(f, "{} {} {}", self.kind, self.name.as_deref().unwrap_or("_"), self.verdict)?;
        if let Some(counts) = &self.counts {
            write!(f, " {counts:?}")?;
        }
        self.gate.as_ref().map_or(Ok(()), |gate| write!(f, " by {gate}"))
    }
}

/// What is missing and what is too much, one line each; empty if the findings are the expected ones.
pub(crate) fn difference(case: &Case, findings: &[Finding]) -> String {
    let mut missing = case.markers.clone();
    let mut anywhere = case.anywhere.clone();
    let mut unexpected = Vec::new();
    for finding in findings {
        if let Some(at) = missing.iter().position(|(line, rule)| *line == finding.line && *rule == finding.rule) {
            missing.remove(at);
        } else if let Some(at) = anywhere.iter().position(|rule| *rule == finding.rule) {
            anywhere.remove(at);
        } else {
            unexpected.push(finding);
        }
    }
    let missing = missing.iter().map(|(line, rule)| format!("  missing:    line {line}: {rule}\n"));
    let anywhere = anywhere.iter().map(|rule| format!("  missing:    anywhere: {rule}\n"));
    let unexpected = unexpected
        .iter()
        .map(|finding| format!("  unexpected: line {}: {}: {}\n", finding.line, finding.rule, finding.message));
    missing.chain(anywhere).chain(unexpected).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(body: &str, expected: &[(usize, &str)]) {
        let case = Case::parse(&format!("//! A case.\n{body}")).expect("the case is well formed");
        let markers: Vec<(usize, &str)> = case.markers.iter().map(|(line, rule)| (*line, rule.as_str())).collect();
        assert_eq!(markers, expected);
    }

    #[track_caller]
    fn check_fails(text: &str, problem: &str) {
        let error = Case::parse(text).expect_err("the case is malformed");
        assert!(error.contains(problem), "{error}");
    }

    fn finding(line: usize, rule: &str) -> Finding {
        Finding { file: "case.rs".to_owned(), line, rule: rule.to_owned(), message: String::new(), is_fixable: false }
    }

    #[test]
    fn marker_means_its_own_line() {
        check("a();\nkf.update(); //~ repeated_update\n", &[(3, "repeated_update")]);
    }

    #[test]
    fn arrows_point_to_other_lines() {
        check(
            "//~vv missed_update\na();\nloop {\n//~^ skipped_update\n",
            &[(4, "missed_update"), (4, "skipped_update")],
        );
    }

    #[test]
    fn one_line_can_hold_two_markers() {
        check("loop { //~ missed_update //~ skipped_update\n", &[(2, "missed_update"), (2, "skipped_update")]);
    }

    #[test]
    fn innocent_case_expects_nothing() {
        check("//@ no-findings\nloop {}\n", &[]);
    }

    #[test]
    fn a_case_can_switch_a_rule_on() {
        let case = Case::parse("//! A case.\n//@ no-findings\n//@ warn: gated_update\n").expect("well formed");
        assert_eq!(case.warned, ["gated_update"]);
        check_fails("//! A case.\n//@ no-findings\n//@ warn: gate_update\n", "unknown rule `gate_update`");
    }

    #[test]
    fn malformed_cases_are_rejected() {
        check_fails("loop {}\n", "starts with");
        check_fails("//! A case.\nloop {}\n", "no expectation");
        check_fails("//! A case.\n//@ no-findings\nloop {} //~ missed_update\n", "beside");
        check_fails("//! A case.\nloop {} //~ mist_update\n", "line 2: unknown rule `mist_update`");
        check_fails("//! A case.\nloop {} //~^^ missed_update\n", "out of the file");
        check_fails("//! A case.\nloop {} //~v missed_update\n", "out of the file");
        check_fails("//! A case.\n//@ no-finding\n", "unknown directive");
        check_fails("//! A case.\n//@ report: 4 loop kf\n", "expected `report:");
        check_fails("//! A case.\n//@ report: 4 loop kf once x\n", "bad counts");
    }

    #[test]
    fn report_line_names_a_pair() {
        let line = ReportLine::parse("14 loop self.axes.roll skipped 0,1").expect("well formed");
        let pair = Pair {
            file: "case.rs".to_owned(),
            function: "Quad::run".to_owned(),
            line: 14,
            kind: "loop".to_owned(),
            name: "self.axes.roll".to_owned(),
            verdict: "skipped".to_owned(),
            counts: vec![0, 1],
            gate: None,
        };
        assert!(line.matches(&pair));
        assert!(ReportLine::parse("Quad::run loop _ skipped _").expect("well formed").matches(&pair));
        for other in
            ["13 loop self.axes.roll skipped 0,1", "14 while self.axes.roll skipped 0,1", "14 loop _ gated _ time"]
        {
            assert!(!ReportLine::parse(other).expect("well formed").matches(&pair), "{other}");
        }
    }

    #[test]
    fn difference_names_both_directions() {
        let case =
            Case::parse("//! A case.\n//@ finds: skipped_update\nf(); //~ repeated_update\n").expect("well formed");
        assert_eq!(difference(&case, &[finding(9, "skipped_update"), finding(3, "repeated_update")]), "");
        let text = difference(&case, &[finding(3, "missed_update"), finding(9, "skipped_update")]);
        assert_eq!(text, "  missing:    line 3: repeated_update\n  unexpected: line 3: missed_update: \n");
    }

    #[test]
    fn second_finding_on_a_line_needs_a_second_marker() {
        let case = Case::parse("//! A case.\nf(); //~ missed_update\n").expect("well formed");
        let text = difference(&case, &[finding(2, "missed_update"), finding(2, "missed_update")]);
        assert!(text.contains("unexpected: line 2"), "{text}");
    }
}
