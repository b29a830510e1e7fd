//! What a check finds that the one before did not: the reason to take a fix back.

use std::collections::{BTreeMap, BTreeSet};

use crate::pipeline::Report;
use crate::source::FileId;

/// Something that a check finds and the one before did not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct News {
    /// The file that it is found in, as it is shown to users.
    pub file: String,
    /// The rule that found it, if one did.
    pub rule: Option<&'static str>,
    /// What it is, in words.
    pub words: String,
}

/// What is in `after` and not in `before`: files that can no longer be read, findings, filters whose updates are no longer proved.
/// Lines do not matter, nor does whether a finding is suppressed.
#[must_use]
pub fn news(before: &Report, after: &Report) -> Vec<News> {
    beyond(told(before), told(after))
}

fn beyond(before: Vec<Told>, after: Vec<Told>) -> Vec<News> {
    // Each filter counts for itself: a finding may tell of fewer filters than before, and two may have become one.
    let mut known: BTreeMap<(Vec<String>, Option<String>), usize> = BTreeMap::new();
    for Told { key, filters, .. } in before {
        for of_filter in each(&filters) {
            *known.entry((key.clone(), of_filter)).or_default() += 1;
        }
    }
    let mut news = Vec::new();
    for Told { key, filters, news: found } in after {
        let mut is_new = false;
        for of_filter in each(&filters) {
            match known.get_mut(&(key.clone(), of_filter)).filter(|left| **left > 0) {
                Some(left) => *left -= 1,
                None => is_new = true,
            }
        }
        if is_new {
            news.push(found);
        }
    }
    news
}

/// The filters of a finding; nothing, once, where it tells of none.
fn each(filters: &BTreeSet<String>) -> Vec<Option<String>> {
    if filters.is_empty() { vec![None] } else { filters.iter().cloned().map(Some).collect() }
}

/// What a fix must not bring.
struct Told {
    /// What it is, but for the filters.
    key: Vec<String>,
    filters: BTreeSet<String>,
    news: News,
}

/// Everything in a report that a fix must not bring.
fn told(report: &Report) -> Vec<Told> {
    let name = |file: FileId| report.sources.file(file).name.clone();
    let mut told = Vec::new();
    let mut add = |file: String, rule: Option<&'static str>, key: Vec<&str>, filters: &[String], words: String| {
        let key = [file.as_str()].into_iter().chain(key).map(str::to_owned).collect();
        told.push(Told { key, filters: filters.iter().cloned().collect(), news: News { file, rule, words } });
    };
    for problem in &report.problems {
        let words = format!("`{}` can no longer be read: {}", problem.file, problem.message);
        add(problem.file.clone(), None, vec![&problem.message], &[], words);
    }
    for finding in &report.diagnostics {
        let words = format!("it would bring `ceid::{}`: {}", finding.rule, finding.message);
        let facts = &finding.facts;
        let file = name(finding.primary.span.file);
        add(file, Some(finding.rule), vec![finding.rule, &facts.function], &facts.filters, words);
    }
    for cycle in &report.cycles {
        for pair in cycle.filters.iter().filter(|pair| !pair.is_proved()) {
            let verdict = pair.verdict.name();
            let why = pair.cause.as_ref().map(|cause| format!(": {cause}")).unwrap_or_default();
            let words = format!("`{}` in `{}` would be {verdict}{why}", pair.name, cycle.function);
            add(
                name(cycle.head.file),
                None,
                vec![verdict, &cycle.function, &pair.law],
                std::slice::from_ref(&pair.name),
                words,
            );
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
        assert_eq!(news(&report(&["a", "b"]), &report(&["b"])), []);
        let found = news(&report(&["a"]), &report(&["a", "a"]));
        let words = "`src/a.rs` can no longer be read: a".to_owned();
        assert_eq!(found, [News { file: "src/a.rs".to_owned(), rule: None, words }]);
    }

    #[test]
    fn a_finding_may_tell_of_other_filters_of_those_that_were_told_of() {
        let finding = |filters: &str| Told {
            key: vec!["src/a.rs".to_owned(), "missed_update".to_owned(), "main".to_owned()],
            filters: filters.split_whitespace().map(str::to_owned).collect(),
            news: News { file: "src/a.rs".to_owned(), rule: Some("missed_update"), words: filters.to_owned() },
        };
        let found = |before: &[&str], after: &[&str]| -> Vec<String> {
            let told = |all: &[&str]| all.iter().map(|filters| finding(filters)).collect();
            beyond(told(before), told(after)).into_iter().map(|news| news.words).collect()
        };
        assert_eq!(found(&["a b", "a b", "a b c"], &["a b", "a b", "a b c"]), [""; 0]);
        assert_eq!(found(&["a b", "c"], &["a b c"]), [""; 0]);
        assert_eq!(found(&["a b c"], &["a c", "b"]), [""; 0]);
        assert_eq!(found(&["a b", "c"], &["a b c", "b"]), ["b"]);
        assert_eq!(found(&["a b"], &["a d"]), ["a d"]);
    }
}
