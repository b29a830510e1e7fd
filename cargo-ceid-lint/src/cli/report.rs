//! `cargo ceid-lint report`: what is proved, not only what is wrong.

use clap::ArgMatches;

use super::args::{DataFormat, ReportArgs};
use super::console::Stream;
use super::{Console, ExitStatus, input, levels};
use crate::report::proof;

/// Prints the proof report. Findings do not decide how it ends: a report has none of its own.
///
/// # Errors
/// What is wrong with the arguments.
pub(super) fn run(mut args: ReportArgs, matches: &ArgMatches) -> Result<ExitStatus, String> {
    let console = Console::new(&args.talk);
    let overrides = levels::read(matches, &args.levels, &mut args.input.build.features, &args.rest)?;
    let Ok(mut checked) = input::check(&args.input, overrides, console, args.talk.stats) else {
        return Ok(ExitStatus::Incomplete);
    };
    if checked.is_unchecked {
        checked.show_problems(console);
        return Ok(ExitStatus::Incomplete);
    }
    console.print(&match args.message_format {
        DataFormat::Human => proof::human(&checked.project, &checked.report, console.style(Stream::Out)),
        DataFormat::Json => proof::json(&checked.project, &checked.report),
    });
    checked.summary.errors = 0;
    Ok(checked.status(&args.input, console))
}
