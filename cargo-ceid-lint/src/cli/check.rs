//! `cargo ceid-lint`, and `cargo ceid-lint check`.

use std::collections::BTreeSet;

use clap::ArgMatches;

use super::args::{CheckArgs, MessageFormat};
use super::console::Stream;
use super::input::{self, Checked};
use super::{Console, ExitStatus, levels};
use crate::report::json::{self, Options, Rendered};
use crate::report::{short, text};

/// Runs the check.
///
/// # Errors
/// What is wrong with the arguments.
pub(super) fn run(mut args: CheckArgs, matches: &ArgMatches) -> Result<ExitStatus, String> {
    let console = Console::new(&args.talk);
    let format = format(&args.message_format)?;
    let overrides = levels::read(matches, &args.levels, &mut args.input.build.features, &args.rest)?;
    let Some(checked) = input::check(&args.input, overrides, console, args.talk.stats) else {
        if let Format::Json(_) = format {
            console.print("{\"reason\":\"build-finished\",\"success\":false}\n");
        }
        return Ok(ExitStatus::Incomplete);
    };
    match format {
        Format::Human => show(&checked, console),
        Format::Short => show_short(&checked, console),
        Format::Json(options) if options.without_diagnostics => show(&checked, console),
        Format::Json(_) => {}
    }
    checked.say_summary(console);
    let status = checked.status(args.input.no_loops, console);
    if let Format::Json(options) = format {
        let success = status == ExitStatus::Clean;
        let without_artifacts = checked.is_config_wrong;
        console.print(&json::messages(
            &checked.project,
            &checked.report,
            Options { success, without_artifacts, ..options },
        ));
    }
    Ok(status)
}

enum Format {
    Human,
    Short,
    Json(Options),
}

/// Puts together what was asked for, as cargo does: several words may describe the JSON, but only one the kind.
fn format(words: &[MessageFormat]) -> Result<Format, String> {
    let mut kinds = Vec::new();
    let mut options = Options::default();
    for word in words {
        let kind = match word {
            MessageFormat::Human => "human",
            MessageFormat::Short => "short",
            MessageFormat::Json => "json",
            MessageFormat::JsonDiagnosticShort => {
                options.rendered = Rendered::Short;
                "json"
            }
            MessageFormat::JsonDiagnosticRenderedAnsi => {
                options.rendered = Rendered::Ansi;
                "json"
            }
            MessageFormat::JsonRenderDiagnostics => {
                options.without_diagnostics = true;
                "json"
            }
        };
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    match kinds.as_slice() {
        [] | ["human"] => Ok(Format::Human),
        ["short"] => Ok(Format::Short),
        ["json"] => Ok(Format::Json(options)),
        _ => Err(format!("cannot print in two kinds of format at once: {}", kinds.join(", "))),
    }
}

fn show(checked: &Checked, console: Console) {
    for diagnostic in checked.report.shown() {
        console.show(&text::diagnostic(&checked.report.sources, diagnostic, console.style(Stream::Err)));
    }
    checked.show_problems(console);
    let rules: BTreeSet<&str> = checked.report.shown().map(|diagnostic| diagnostic.rule).collect();
    if let Some(first) = checked.report.shown().next() {
        let what = if rules.len() == 1 { "this rule" } else { "a rule" };
        console.say(&format!("for more about {what}, run `cargo ceid-lint explain {}`", first.rule));
    }
}

fn show_short(checked: &Checked, console: Console) {
    for diagnostic in checked.report.shown() {
        console.show(&short::diagnostic(&checked.report.sources, diagnostic));
    }
    for problem in checked.report.errors() {
        console.show(&short::problem(&checked.report.sources, problem));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_about_json_can_be_combined() {
        let words = [MessageFormat::JsonDiagnosticRenderedAnsi, MessageFormat::JsonRenderDiagnostics];
        let Ok(Format::Json(options)) = format(&words) else { panic!("it is JSON") };
        assert!(options.without_diagnostics && options.rendered == Rendered::Ansi);
        assert!(format(&[MessageFormat::Json, MessageFormat::Human]).is_err());
        assert!(matches!(format(&[]), Ok(Format::Human)));
    }
}
