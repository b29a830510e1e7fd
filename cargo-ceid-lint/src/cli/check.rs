//! `cargo ceid-lint`, and `cargo ceid-lint check`.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::ArgMatches;

use super::args::CheckArgs;
use super::console::Stream;
use super::fix::{self, Fixed};
use super::format::{Format, OutputFile, add_step_summary};
use super::input::{self, Checked, Since};
use super::timings::clock;
use super::{Console, ExitStatus, beside, levels};
use crate::pipeline::Options;
use crate::report::{Outcome, Service, text};

/// Runs the check.
///
/// # Errors
/// What is wrong with the arguments.
pub(super) fn run(mut args: CheckArgs, matches: &ArgMatches) -> Result<ExitStatus, String> {
    let console = Console::configured(&args.talk, &args.input.build.config);
    let mut format = Format::read(&args.message_format)?;
    if let (Some(_), Format::Json(options)) = (args.beside, &mut format) {
        // A clean package would take back what cargo has said of it.
        options.without_artifacts = true;
    }
    let files: Vec<OutputFile> =
        args.output.iter().map(|text| OutputFile::read(text, format)).collect::<Result<_, _>>()?;
    // What goes into a file without a name of its own is not printed as well.
    let is_in_file = files.iter().any(|file| !file.is_named);
    let printed = if is_in_file { Format::Human } else { format };
    only_one_on_stdout(printed, &files)?;
    let overrides = levels::read(matches, &args.levels, &mut args.input.build.features, &args.rest)?;
    let since = args.legacy.since.as_deref().map(|revision| Since { revision, is_about_cycles: false });
    let options = Options {
        overrides,
        baseline: input::baseline(&args.legacy),
        gate: input::gate(&args.input),
        clock: clock(&args.talk),
        ..Options::default()
    };
    let cargo = args.beside.map(|command| beside::run(command, &args, console));
    let loaded = if fix::is_asked(&args, printed)? {
        match fix::run(&args, &options, printed, console) {
            Ok(Fixed::Ended(status)) => return Ok(status),
            Ok(Fixed::Checked(checked, is_unwritten)) => Ok((*checked, is_unwritten)),
            Err(error) => Err(input::Failed::of_load(error)),
        }
    } else {
        input::check(&args.input, &options, since, console, &args.talk).map(|checked| (checked, false))
    };
    let (checked, mut status) = match loaded {
        Ok((checked, is_unwritten)) => {
            show(&checked, printed, console);
            checked.say_summary(console);
            let status = checked.status(&args.input, console);
            (checked, if is_unwritten { ExitStatus::Incomplete } else { status })
        }
        Err(failed) => (Checked::of_failed(*failed), ExitStatus::Incomplete),
    };
    if cargo.is_some_and(|is_well| !is_well) {
        status = ExitStatus::Incomplete;
    }
    let part = args.input.scope.partition.map(|part| part.to_string());
    let outcome = Outcome { exit_code: status.code(), part };
    if let Format::Json(_) | Format::Service(_) = printed {
        console.print(&printed.render(&checked, &outcome));
    }
    let mut results: Vec<Result<(), String>> =
        files.iter().map(|file| file.write(&checked, &outcome, console)).collect();
    let is_for_github = |format: Format| matches!(format, Format::Service(Service::Github));
    let summary = std::env::var_os("GITHUB_STEP_SUMMARY").filter(|path| !path.is_empty()).map(PathBuf::from);
    if is_for_github(printed) || files.iter().any(|file| is_for_github(file.format)) {
        results.extend(summary.map(|path| add_step_summary(&checked, &path)));
    }
    for error in results.into_iter().filter_map(Result::err) {
        console.error(&error, None);
        status = ExitStatus::Incomplete;
    }
    Ok(status)
}

/// Whoever reads stdout by program reads one form.
fn only_one_on_stdout(printed: Format, files: &[OutputFile]) -> Result<(), String> {
    let is_printed = matches!(printed, Format::Json(_) | Format::Service(_));
    let on_stdout = files.iter().filter(|file| file.path.as_os_str() == "-").count() + usize::from(is_printed);
    if on_stdout < 2 {
        return Ok(());
    }
    Err("cannot print two forms on stdout at once; name a file for one of them, as in `--output sarif=ceid.sarif`"
        .to_owned())
}

/// Shows the findings to people, where that is what was asked for.
fn show(checked: &Checked, printed: Format, console: Console) {
    match printed {
        Format::Human => show_with_source(checked, console),
        Format::Json(options) if options.without_diagnostics => show_with_source(checked, console),
        Format::Short => console.show(&Format::Short.render(checked, &Outcome::default())),
        Format::Json(_) | Format::Service(_) => {}
    }
}

fn show_with_source(checked: &Checked, console: Console) {
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
