//! `cargo ceid-lint baseline`: the counts of what is known, written, extended and pruned.

pub(super) mod args;

use args::BaselineArgs;
use clap::ArgMatches;

use super::input::{self, Checked};
use super::timings::clock;
use super::{Console, ExitStatus, levels};
use crate::baseline::{self, Comparison};
use crate::pipeline::{BaselineChoice, Options};
use crate::report::{count, short, stale};
use crate::source::{self, DiskSource, ReadSource as _};

/// Checks, and writes the file of each workspace.
///
/// # Errors
/// What is wrong with the arguments.
pub(super) fn run(mut args: BaselineArgs, matches: &ArgMatches) -> Result<ExitStatus, String> {
    let console = Console::new(&args.talk);
    let overrides = levels::read(matches, &args.levels, &mut args.input.build.features, &args.rest)?;
    let choice = BaselineChoice::ToWrite(args.baseline.as_deref().map(input::from_current_dir));
    let options = Options {
        overrides,
        baseline: choice,
        gate: input::gate(&args.input),
        clock: clock(&args.talk),
        ..Options::default()
    };
    let Ok(checked) = input::check(&args.input, &options, None, console, &args.talk) else {
        return Ok(ExitStatus::Incomplete);
    };
    checked.show_problems(console);
    if checked.is_unchecked {
        return Ok(ExitStatus::Incomplete);
    }
    let comparisons = &checked.report.baselines;
    if comparisons.is_empty() {
        console.error(
            "there is no manifest beside which the baseline could stand",
            Some("`--baseline FILE` names a file"),
        );
        return Ok(ExitStatus::Incomplete);
    }
    let mut status = checked.status_of_run(&args.input, console);
    for comparison in comparisons {
        let own = write(comparison, &args, &checked, console);
        status = if status == ExitStatus::Incomplete || own == ExitStatus::Clean { status } else { own };
    }
    Ok(status)
}

/// Does what was asked for with one file, and says what came of it.
fn write(comparison: &Comparison, args: &BaselineArgs, checked: &Checked, console: Console) -> ExitStatus {
    let path = input::shown(&comparison.path);
    if comparison.old.is_none() && args.prune && !args.accept_new {
        let help = "`cargo ceid-lint baseline` writes it";
        console.error(&format!("there is no baseline `{path}` to take anything out of"), Some(help));
        return ExitStatus::Incomplete;
    }
    let is_first = comparison.old.is_none();
    let counts = comparison.updated(args.accept_new || is_first, args.prune);
    let is_changed = comparison.old.as_ref() != Some(&counts);
    if let Some(directory) = comparison.path.parent() {
        source::remove_abandoned(directory, std::time::SystemTime::now());
    }
    if is_changed {
        let old = DiskSource.read(&comparison.path).unwrap_or_default();
        if let Err(error) = source::write(&comparison.path, &baseline::text(&counts, &old)) {
            console.error(&format!("cannot write `{path}`: {error}"), None);
            return ExitStatus::Incomplete;
        }
    }
    let total: u32 = counts.values().sum();
    let added = if args.accept_new || is_first { comparison.new_findings() } else { 0 };
    let removed = if args.prune { comparison.stale() } else { 0 };
    let finding = |number: u32| count(number as usize, "finding");
    if comparison.forbidden > 0 {
        let are = if comparison.forbidden == 1 { "is" } else { "are" };
        let number = count(comparison.forbidden, "finding");
        console.warn(&format!("{number} of forbidden rules {are} left out: nothing hides what is forbidden"));
    }
    if is_first {
        console.say(&format!("wrote `{path}` with {}", finding(total)));
    } else if is_changed {
        let parts = [("added", added), ("took out", removed)];
        let parts: Vec<String> = parts
            .iter()
            .filter(|(_, number)| *number > 0)
            .map(|(verb, number)| format!("{verb} {}", finding(*number)))
            .collect();
        console.say(&format!("{}: `{path}` holds {}", parts.join(", "), finding(total)));
    }
    if args.prune && checked.summary.problems > 0 {
        console.say("nothing is taken out while something could not be read");
    }
    let left_new = comparison.new_findings() - added;
    let left_stale = comparison.stale() - removed;
    if left_new > 0 {
        for diagnostic in checked.report.shown() {
            console.show(&short::diagnostic(&checked.report.sources, diagnostic));
        }
        let what = format!("{} not in `{path}`", new(left_new));
        console.error(&what, Some("`--accept-new` adds what is meant to stay; better, correct it"));
    }
    if let Some(stale) = stale(left_stale, &path) {
        console.say(&stale);
    }
    if !is_changed && left_new == 0 && left_stale == 0 {
        console.say(&format!("`{path}` is up to date: it holds {}", finding(total)));
    }
    if left_new > 0 { ExitStatus::Findings } else { ExitStatus::Clean }
}

fn new(number: u32) -> String {
    if number == 1 { "1 finding is".to_owned() } else { format!("{number} findings are") }
}
