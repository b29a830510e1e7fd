//! What was left unread though nothing is wrong with it, said once at the end of a run.

use crate::diagnostic::Problem;
use crate::pipeline::Report;
use crate::source::SourceMap;

/// How many names a cause lists beside the first one before it says how many more there are.
const MOST_NAMES: usize = 2;

/// A line for each cause, below a heading; `None` if everything was read. The proof report lists all places.
#[must_use]
pub fn unread(report: &Report) -> Option<String> {
    let mut causes: Vec<Vec<&Problem>> = Vec::new();
    for problem in &report.unread {
        let cause = without_names(&problem.message);
        match causes.iter_mut().find(|alike| without_names(&alike[0].message) == cause) {
            Some(alike) => alike.push(problem),
            None => causes.push(vec![problem]),
        }
    }
    let number = report.unread.len();
    let verb = if number == 1 { "was" } else { "were" };
    let list = if number > causes.len() { ", which `cargo ceid-lint report` lists" } else { "" };
    let mut text = format!("{} {verb} left unread{list}:", super::count(number, "place"));
    for alike in &causes {
        let first = alike[0];
        let place = place(&report.sources, first);
        let others = if alike.len() > 1 { format!(" and {} more", alike.len() - 1) } else { String::new() };
        text += &format!("\n  {place}{others}: {}{}", first.message, same_of(alike));
        text += &first.help.as_ref().map_or_else(String::new, |help| format!("; {help}"));
    }
    (number > 0).then_some(text)
}

/// What of a message is not a name: every other part between its backticks.
fn without_names(message: &str) -> Vec<&str> {
    message.split('`').step_by(2).collect()
}

/// The names of which the cause of the first place is told as well.
fn same_of(alike: &[&Problem]) -> String {
    let names =
        |problem: &'_ Problem| problem.message.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
    let first = names(alike[0]);
    let mut others: Vec<String> = Vec::new();
    for problem in alike {
        let other = names(problem).into_iter().zip(&first).find(|(name, first)| name != *first);
        others.extend(other.map(|(name, _)| name).filter(|name| !others.contains(name)));
    }
    let shown: Vec<String> = others.iter().take(MOST_NAMES).map(|name| format!("`{name}`")).collect();
    match (others.len(), others.len().saturating_sub(MOST_NAMES)) {
        (0, _) => String::new(),
        (_, 0) => format!(" (the same of {})", shown.join(" and ")),
        (_, more) => format!(" (the same of {} and {more} more)", shown.join(", ")),
    }
}

/// The place and the cause.
pub(super) fn line(sources: &SourceMap, problem: &Problem) -> String {
    format!("{}: {}", place(sources, problem), problem.message)
}

fn place(sources: &SourceMap, problem: &Problem) -> String {
    match problem.span {
        Some(span) => format!("{}:{}", problem.file, sources.line(span)),
        None => problem.file.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(number: usize) -> Report {
        let problem = |at: usize| Problem {
            file: format!("src/old_{at}.rs"),
            span: None,
            message: "belongs to no target".to_owned(),
            help: Some("declare it".to_owned()),
            is_error: false,
        };
        Report { unread: (0..number).map(problem).collect(), ..Report::default() }
    }

    #[test]
    fn one_place_is_told_with_its_cause_and_what_to_do() {
        assert_eq!(unread(&report(0)), None);
        let expected = "1 place was left unread:\n  src/old_0.rs: belongs to no target; declare it";
        assert_eq!(unread(&report(1)).as_deref(), Some(expected));
    }

    #[test]
    fn a_cause_is_told_once() {
        let mut report = report(20);
        report.unread.push(Problem {
            message: "is made by a build script".to_owned(),
            help: None,
            ..report.unread[0].clone()
        });
        let expected = "21 places were left unread, which `cargo ceid-lint report` lists:\n  \
                        src/old_0.rs and 19 more: belongs to no target; declare it\n  src/old_0.rs: is made by a build script";
        assert_eq!(unread(&report).as_deref(), Some(expected));
    }

    #[test]
    fn what_differs_in_its_names_only_is_one_cause() {
        let with = |names: &[&str]| {
            let mut report = report(names.len());
            for (problem, name) in report.unread.iter_mut().zip(names) {
                problem.message = format!("`{name}` is made by `build.rs`");
            }
            unread(&report).unwrap_or_default()
        };
        let told = with(&["a", "b", "a", "c"]);
        assert!(
            told.ends_with("src/old_0.rs and 3 more: `a` is made by `build.rs` (the same of `b` and `c`); declare it"),
            "{told}"
        );
        let told = with(&["a", "b", "c", "d", "e"]);
        assert!(told.contains("(the same of `b`, `c` and 2 more)"), "{told}");
        let told = with(&["a", "a"]);
        assert!(told.ends_with("src/old_0.rs and 1 more: `a` is made by `build.rs`; declare it"), "{told}");
    }
}
