//! What was left unread though nothing is wrong with it, said once at the end of a run.

use crate::diagnostic::Problem;
use crate::pipeline::Report;
use crate::source::SourceMap;

/// A line for each cause, below a heading; `None` if everything was read. The proof report lists all places.
#[must_use]
pub fn unread(report: &Report) -> Option<String> {
    let mut causes: Vec<(&Problem, usize)> = Vec::new();
    for problem in &report.unread {
        match causes.iter_mut().find(|(first, _)| first.message == problem.message) {
            Some((_, number)) => *number += 1,
            None => causes.push((problem, 1)),
        }
    }
    let number = report.unread.len();
    let verb = if number == 1 { "was" } else { "were" };
    let list = if number > causes.len() { ", which `cargo ceid-lint report` lists" } else { "" };
    let mut text = format!("{} {verb} left unread{list}:", super::count(number, "place"));
    for (first, number) in &causes {
        let place = place(&report.sources, first);
        let others = if *number > 1 { format!(" and {} more", number - 1) } else { String::new() };
        text += &format!("\n  {place}{others}: {}", first.message);
        text += &first.help.as_ref().map_or_else(String::new, |help| format!("; {help}"));
    }
    (number > 0).then_some(text)
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
}
