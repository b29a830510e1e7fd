//! `cargo ceid-lint report`: what is proved, not only what is wrong.

use std::path::{Path, PathBuf};

use clap::ArgMatches;

use super::args::{ReportArgs, ReportFormat};
use super::console::Stream;
use super::format::{named_output, write_output};
use super::input::{self, Checked, Since};
use super::timings::clock;
use super::{Console, ExitStatus, levels};
use crate::pipeline::Options;
use crate::report::progress::{Previous, Trend};
use crate::report::{Style, asides, html, proof};

/// Prints the proof report. Findings do not decide how it ends: a report has none of its own.
///
/// # Errors
/// What is wrong with the arguments.
pub(super) fn run(mut args: ReportArgs, matches: &ArgMatches) -> Result<ExitStatus, String> {
    let console = Console::configured(&args.talk, &args.input.build.config);
    let outputs: Vec<(Option<ReportFormat>, PathBuf)> =
        args.output.iter().map(|text| named_output(text)).collect::<Result<_, _>>()?;
    let overrides = levels::read(matches, &args.levels, &mut args.input.build.features, &args.rest)?;
    let previous = match args.compare_with.as_deref().map(previous).transpose() {
        Ok(previous) => previous,
        Err(error) => {
            let help = "`cargo ceid-lint report --message-format json` writes one";
            console.error(&error, Some(help));
            return Ok(ExitStatus::Incomplete);
        }
    };
    let options = Options {
        overrides,
        baseline: input::baseline(&args.legacy),
        gate: input::gate(&args.input),
        clock: clock(&args.talk),
        ..Options::default()
    };
    let since = args.legacy.since.as_deref().map(|revision| Since { revision, is_about_cycles: true });
    let Ok(mut checked) = input::check(&args.input, &options, since, console, &args.talk) else {
        return Ok(ExitStatus::Incomplete);
    };
    if checked.is_unchecked {
        checked.show_problems(console);
        return Ok(ExitStatus::Incomplete);
    }
    let trend = previous.map(|previous| previous.trend(&checked.project, &checked.report));
    // What goes into a file without a name of its own is not printed as well.
    let is_in_file = outputs.iter().any(|(format, _)| format.is_none());
    if !is_in_file {
        console.print(&render(args.message_format, &checked, trend.as_ref(), console.style(Stream::Out)));
    }
    for line in asides(&checked.report) {
        console.say(&line);
    }
    let mut is_written = true;
    for (format, path) in &outputs {
        let format = format.unwrap_or(args.message_format);
        let text = render(format, &checked, trend.as_ref(), Style::default());
        if let Err(error) = write_output(path, &text, console) {
            console.error(&error, None);
            is_written = false;
        }
    }
    checked.summary.errors = 0;
    let status = checked.status(&args.input, console);
    Ok(if is_written { status } else { ExitStatus::Incomplete })
}

fn previous(path: &Path) -> Result<Previous, String> {
    let text = std::fs::read_to_string(path).map_err(|error| error.to_string());
    text.and_then(|text| Previous::read(&text))
        .map_err(|error| format!("cannot compare with the report `{}`: {error}", path.display()))
}

fn render(format: ReportFormat, checked: &Checked, trend: Option<&Trend>, style: Style) -> String {
    let (project, report) = (&checked.project, &checked.report);
    match format {
        ReportFormat::Human => proof::human(project, report, trend, style),
        ReportFormat::Json => proof::json(project, report, trend),
        ReportFormat::Html => html::page(project, report, trend),
    }
}
