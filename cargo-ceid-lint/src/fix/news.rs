//! What a check finds that the one before did not: the reason to take a fix back.

use std::collections::BTreeMap;

use crate::pipeline::Report;
use crate::source::FileId;

/// The first thing that is in `after` and not in `before`, in words: a file that can no longer be read, a finding, a filter whose
/// updates are no longer proved. Lines do not matter, nor does whether a finding is suppressed.
#[must_use]
pub fn news(before: &Report, after: &Report) -> Option<String> {
    let mut known = counted(before);
    for (key, words) in told(after) {
        match known.get_mut(&key) {
            Some(left) if *left > 0 => *left -= 1,
            _ => return Some(words),
        }
    }
    None
}

type Key = Vec<String>;

fn counted(report: &Report) -> BTreeMap<Key, usize> {
    let mut counted = BTreeMap::new();
    for (key, _) in told(report) {
        *counted.entry(key).or_default() += 1;
    }
    counted
}

/// Everything in a report that a fix must not bring, with its words.
fn told(report: &Report) -> Vec<(Key, String)> {
    let name = |file: FileId| report.sources.file(file).name.clone();
    let mut told = Vec::new();
    for problem in &report.problems {
        let words = format!("`{}` can no longer be read: {}", problem.file, problem.message);
        told.push((vec![problem.file.clone(), problem.message.clone()], words));
    }
    for finding in &report.diagnostics {
        let facts = &finding.facts;
        let key = vec![
            finding.rule.to_owned(),
            name(finding.primary.span.file),
            facts.function.clone(),
            facts.filters.join(", "),
        ];
        told.push((key, format!("it would bring `ceid::{}`: {}", finding.rule, finding.message)));
    }
    for cycle in &report.cycles {
        for pair in cycle.filters.iter().filter(|pair| !pair.verdict.is_proved()) {
            let verdict = pair.verdict.name();
            let key = vec![
                verdict.to_owned(),
                name(cycle.head.file),
                cycle.function.clone(),
                pair.name.clone(),
                pair.law.clone(),
            ];
            told.push((key, format!("`{}` in `{}` would be {verdict}", pair.name, cycle.function)));
        }
    }
    told
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::SourceMap;

    fn report(problems: &[&str]) -> Report {
        let problem = |message: &&str| crate::diagnostic::Problem {
            file: "src/a.rs".to_owned(),
            span: None,
            message: (*message).to_owned(),
            help: None,
            is_error: true,
        };
        Report { sources: SourceMap::default(), problems: problems.iter().map(problem).collect(), ..Report::default() }
    }

    #[test]
    fn each_thing_is_known_as_often_as_it_was_there() {
        assert_eq!(news(&report(&["a", "b"]), &report(&["b"])), None);
        assert_eq!(news(&report(&["a"]), &report(&["a", "a"])).as_deref(), Some("`src/a.rs` can no longer be read: a"));
    }
}
