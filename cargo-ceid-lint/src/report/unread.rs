//! What was left unread though nothing is wrong with it, said once at the end of a run.

use crate::diagnostic::Problem;
use crate::pipeline::Report;
use crate::source::SourceMap;

/// How many places are listed; the proof report lists all.
const MOST_LISTED: usize = 8;

/// A line for each place that was left unread, below a heading; `None` if everything was read.
#[must_use]
pub fn unread(report: &Report) -> Option<String> {
    let number = report.unread.len();
    if number == 0 {
        return None;
    }
    let verb = if number == 1 { "was" } else { "were" };
    let mut text = format!("{} {verb} left unread:", super::count(number, "place"));
    for problem in report.unread.iter().take(MOST_LISTED) {
        text += &format!("\n  {}", line(&report.sources, problem));
        text += &problem.help.as_ref().map_or_else(String::new, |help| format!("; {help}"));
    }
    if number > MOST_LISTED {
        text += &format!("\n  and {} more, which `cargo ceid-lint report` lists", number - MOST_LISTED);
    }
    Some(text)
}

/// The place and the cause.
pub(super) fn line(sources: &SourceMap, problem: &Problem) -> String {
    match problem.span {
        Some(span) => format!("{}:{}: {}", problem.file, sources.line(span), problem.message),
        None => format!("{}: {}", problem.file, problem.message),
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
    fn long_lists_end_in_a_number() {
        let text = unread(&report(20)).unwrap();
        assert_eq!(text.lines().count(), 1 + MOST_LISTED + 1);
        assert!(text.ends_with("and 12 more, which `cargo ceid-lint report` lists"), "{text}");
    }
}
