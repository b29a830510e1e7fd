//! The human form: the place in the source, the witness as numbered labels, notes and helps.

use codespan_reporting::diagnostic as shown;
use codespan_reporting::term::{self, DisplayStyle, Styles, StylesWriter, termcolor};

use super::files::{View, bytes, is_on_a_long_line};
use super::{Style, Summary, asides, count};
use crate::diagnostic::{Diagnostic, Problem, Severity, Suggestion, WitnessStep};
use crate::pipeline::Report;
use crate::source::{FileId, SourceMap};

/// How many steps of a witness are shown without `--full-trace`.
const MOST_STEPS: usize = 7;

/// A finding with its source, ending in an empty line.
#[must_use]
pub fn diagnostic(sources: &SourceMap, diagnostic: &Diagnostic, style: Style) -> String {
    let severity = match diagnostic.severity() {
        Severity::Error => shown::Severity::Error,
        Severity::Warning => shown::Severity::Warning,
    };
    let primary = diagnostic.primary.span;
    let steps = merged_steps(diagnostic);
    let all = steps.len();
    let steps = shown_steps(steps, style);
    let left_out = all - steps.len();
    let mut primary_message = diagnostic.primary.message.clone();
    let mut labels = Vec::new();
    for (number, step) in &steps {
        if step.span == primary {
            // The step says where the primary place is on the path; its own words are used if the place has none.
            let message =
                if diagnostic.primary.message.is_empty() { &step.message } else { &diagnostic.primary.message };
            primary_message = format!("{number}: {message}");
        } else {
            let range = bytes(sources.file(step.span.file), step.span);
            let message = format!("{number}: {}", step.message);
            labels.push(shown::Label::secondary(step.span.file, range).with_message(message));
        }
    }
    let range = bytes(sources.file(primary.file), primary);
    labels.insert(0, shown::Label::primary(primary.file, range).with_message(primary_message));

    let mut notes = Vec::new();
    let is_long =
        diagnostic.witness.steps.iter().map(|step| step.span).chain([primary]).any(|it| is_on_a_long_line(sources, it));
    if is_long {
        let place = |step: &WitnessStep| format!("{}:{}", sources.file(step.span.file).name, sources.line(step.span));
        notes.extend(steps.iter().map(|(number, step)| format!("step {number}: {} ({})", step.message, place(step))));
    }
    if left_out > 0 {
        notes.push(format!("note: {} of the path left out; `--full-trace` shows all", count(left_out, "step")));
    }
    notes.extend(diagnostic.notes.iter().map(|note| format!("note: {note}")));
    notes.extend(level_note(diagnostic).map(|note| format!("note: {note}")));
    notes.extend(diagnostic.helps.iter().map(|help| format!("help: {help}")));
    notes.extend(diagnostic.suggestions.iter().map(|suggestion| format!("help: {}", suggested(suggestion))));
    let shown = shown::Diagnostic::new(severity)
        .with_code(format!("ceid::{}", diagnostic.rule))
        .with_message(&diagnostic.message)
        .with_labels(labels)
        .with_notes(notes);
    render(sources, &shown, style, is_long)
}

/// What cannot be read or parsed, ending in an empty line.
#[must_use]
pub fn problem(sources: &SourceMap, problem: &Problem, style: Style) -> String {
    let notes = problem.help.iter().map(|help| format!("help: {help}")).collect();
    let shown = shown::Diagnostic::error().with_notes(notes);
    match problem.span {
        Some(span) => {
            let label = shown::Label::primary(span.file, bytes(sources.file(span.file), span));
            let is_long = is_on_a_long_line(sources, span);
            render(sources, &shown.with_message(&problem.message).with_labels(vec![label]), style, is_long)
        }
        None => {
            // What names its file in the message has none besides.
            let message = match problem.file.as_str() {
                "" => problem.message.clone(),
                file => format!("`{file}`: {}", problem.message),
            };
            render(sources, &shown.with_message(message), style, false)
        }
    }
}

/// All findings that are shown, what could not be read, and the summary, as a text that needs no terminal.
#[must_use]
pub fn report(report: &Report) -> String {
    let (sources, style) = (&report.sources, Style::default());
    let findings = report.shown().map(|finding| diagnostic(sources, finding, style));
    let problems = report.problems.iter().map(|it| problem(sources, it, style));
    let lines = [Summary::of(report).line()].into_iter().chain(asides(report)).map(|line| line + "\n");
    findings.chain(problems).chain(lines).collect()
}

/// The steps, those at the primary place as one: it has one label.
fn merged_steps(diagnostic: &Diagnostic) -> Vec<&WitnessStep> {
    let steps = &diagnostic.witness.steps;
    let last = steps.iter().rposition(|step| step.span == diagnostic.primary.span);
    let is_shown = |(at, step): &(usize, &WitnessStep)| step.span != diagnostic.primary.span || Some(*at) == last;
    steps.iter().enumerate().filter(is_shown).map(|(_, step)| step).collect()
}

/// The steps to show, with their numbers: the head of the cycle, and the end of the path.
fn shown_steps(steps: Vec<&WitnessStep>, style: Style) -> Vec<(usize, &WitnessStep)> {
    let count = steps.len();
    let numbered = steps.into_iter().enumerate().map(|(at, step)| (at + 1, step));
    if style.full_trace || count <= MOST_STEPS {
        return numbered.collect();
    }
    let first_of_the_end = count - (MOST_STEPS - 1);
    numbered.filter(|(number, _)| *number == 1 || *number > first_of_the_end).collect()
}

/// Where the level comes from, unless it is the rule's own.
#[must_use]
pub fn level_note(diagnostic: &Diagnostic) -> Option<String> {
    let source = &diagnostic.level_source;
    let is_asked_for = !source.is_empty() && source != "by default";
    is_asked_for.then(|| format!("`ceid::{}` is set to `{}` {source}", diagnostic.rule, diagnostic.level.name()))
}

/// What a suggestion does, with what it writes if that is short.
#[must_use]
pub fn suggested(suggestion: &Suggestion) -> String {
    match suggestion.edits.as_slice() {
        [(_, text)] if !text.trim().is_empty() && !text.contains('\n') => {
            format!("{}: `{}`", suggestion.message, text.trim())
        }
        _ => suggestion.message.clone(),
    }
}

fn render(sources: &SourceMap, shown: &shown::Diagnostic<FileId>, style: Style, is_short: bool) -> String {
    let view = View { sources, hyperlinks: style.hyperlinks };
    let display_style = if is_short { DisplayStyle::Medium } else { DisplayStyle::Rich };
    let config = term::Config { display_style, ..term::Config::default() };
    let mut buffer = Vec::new();
    let result = if style.color {
        let styles = Styles::default();
        let mut writer = StylesWriter::new(termcolor::Ansi::new(&mut buffer), &styles);
        term::emit_to_write_style(&mut writer, &config, &view, shown)
    } else {
        term::emit_to_io_write(&mut buffer, &config, &view, shown)
    };
    let text = String::from_utf8_lossy(&buffer).into_owned();
    match result {
        // Every finding is shown, even one whose place cannot be.
        Err(_) => format!("{text}{}\n\n", shown.message),
        Ok(()) if is_short => format!("{text}\n"),
        Ok(()) => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;

    #[test]
    fn repeated_update() {
        let (_, report) = sample::report();
        insta::assert_snapshot!(diagnostic(&report.sources, &report.diagnostics[0], Style::default()));
    }

    #[test]
    fn a_problem_with_and_without_a_place() {
        let (_, report) = sample::report();
        let texts: Vec<String> =
            report.problems.iter().map(|it| problem(&report.sources, it, Style::default())).collect();
        insta::assert_snapshot!(texts.concat());
    }

    #[test]
    fn long_witnesses_keep_their_head_and_their_end() {
        let (_, mut report) = sample::report();
        let step = report.diagnostics[0].witness.steps[0].clone();
        report.diagnostics[0].witness.steps = vec![step; 12];
        let short = diagnostic(&report.sources, &report.diagnostics[0], Style::default());
        assert!(short.contains("5 steps of the path left out"), "{short}");
        assert!(short.contains("1: ") && short.contains("12: ") && !short.contains(" 6: "), "{short}");
        let full = diagnostic(&report.sources, &report.diagnostics[0], Style { full_trace: true, ..Style::default() });
        assert!(full.contains("6: ") && !full.contains("left out"), "{full}");
    }

    #[test]
    fn colours_are_ansi_and_only_on_demand() {
        let (_, report) = sample::report();
        let text = |color| diagnostic(&report.sources, &report.diagnostics[0], Style { color, ..Style::default() });
        assert!(text(true).contains("\u{1b}["));
        assert!(!text(false).contains("\u{1b}["));
    }

    #[test]
    fn name_of_the_file_is_a_link_on_demand() {
        let (_, report) = sample::report();
        let style = Style { hyperlinks: true, ..Style::default() };
        let linked = diagnostic(&report.sources, &report.diagnostics[0], style);
        let file = report.sources.file(report.diagnostics[0].primary.span.file);
        let name = format!("\x1b]8;;{}\x1b\\{}\x1b]8;;\x1b\\", crate::source::file_url(&file.path), file.name);
        assert!(linked.contains(&format!("{name}:5:")), "{linked:?}");
        let plain = diagnostic(&report.sources, &report.diagnostics[0], Style::default());
        assert_eq!(linked.replace(&name, &file.name), plain);
    }

    #[test]
    fn a_very_long_line_is_not_shown() {
        let (_, mut report) = sample::report();
        let text = format!("fn f() {{ {} }}", "x();".repeat(10_000));
        let file = report.sources.add(std::path::Path::new("/ws/long.rs"), text.into());
        report.diagnostics[0].primary.span = crate::source::Span::new(file, 9, 12);
        let text = diagnostic(&report.sources, &report.diagnostics[0], Style::default());
        assert!(text.len() < 2_000 && text.contains("long.rs:1:10"), "{text}");
    }

    #[test]
    fn a_level_that_was_asked_for_says_where() {
        let (_, mut report) = sample::report();
        report.diagnostics[0].level_source = "on the command line".to_owned();
        let text = diagnostic(&report.sources, &report.diagnostics[0], Style::default());
        assert!(text.contains("`ceid::repeated_update` is set to `deny` on the command line"), "{text}");
    }
}
