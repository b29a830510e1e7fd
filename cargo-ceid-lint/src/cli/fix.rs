//! `cargo ceid-lint fix`, and `--fix`: what the findings offer is done, and what is left is shown as a check shows it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use super::args::{CheckArgs, FixArgs};
use super::format::Format;
use super::input::{self, Checked, Loaded};
use super::{Console, ExitStatus, interrupted, migrate, vcs};
use crate::fix::{self, Bounds, Pasted, Revision};
use crate::pipeline::{BaselineChoice, Options, Purpose, Report};
use crate::project::{LoadError, Project};
use crate::report::json;
use crate::source::{DiskSource, ReadSource, SourceFile, SourceMap};

/// How the fixing went.
pub(super) enum Fixed {
    /// What is left is to be shown; whether something could not be written.
    Checked(Box<Checked>, bool),
    /// Everything is said.
    Ended(ExitStatus),
}

/// Whether the arguments ask for fixes.
///
/// # Errors
/// If they ask for what does not go together.
pub(super) fn is_asked(args: &CheckArgs, printed: Format) -> Result<bool, String> {
    let FixArgs { fix, diff, unsafe_fixes, allow_dirty, allow_staged, allow_no_vcs } = args.fixes;
    if !fix && !diff {
        return if unsafe_fixes || allow_dirty || allow_staged || allow_no_vcs {
            Err("`--unsafe-fixes`, `--allow-dirty`, `--allow-staged` and `--allow-no-vcs` need `--fix`".to_owned())
        } else {
            Ok(false)
        };
    }
    if args.input.stdin_filename.is_some() {
        return Err("`--stdin-filename` cannot be used with fixes: the file on the disk is another text".to_owned());
    }
    if args.legacy.since.is_some() {
        return Err("`--since` cannot be used with fixes: name files instead".to_owned());
    }
    if args.beside.is_some() {
        return Err(
            "`--with` cannot be used with fixes: what cargo says would be about the code before them".to_owned()
        );
    }
    if args.legacy.since.is_some() {
        return Err("`--since` cannot be used with fixes: name the files that are to be fixed".to_owned());
    }
    if diff && (!args.output.is_empty() || matches!(printed, Format::Service(_))) {
        return Err("`--diff` writes nothing: it is printed for people or as JSON".to_owned());
    }
    Ok(true)
}

/// Does it.
///
/// # Errors
/// Why nothing could be loaded, which was told.
pub(super) fn run(args: &CheckArgs, options: &Options, printed: Format, console: Console) -> Result<Fixed, LoadError> {
    let Loaded { project, first } = input::load(&args.input, options, console)?;
    let bounds = Bounds::of(&project);
    if !args.fixes.diff {
        if interrupted::complete(&bounds, console) {
            return Ok(Fixed::Ended(ExitStatus::Incomplete));
        }
        remove_abandoned(&bounds, &project, &first.report);
    }
    let refusal = bounds.repositories().find_map(|root| vcs::check(root, &args.fixes).err());
    if let Some(refusal) = refusal.filter(|_| !args.fixes.diff) {
        console.error(&refusal, None);
        return Ok(Fixed::Ended(ExitStatus::Incomplete));
    }
    if first.is_config_wrong || !first.report.problems.is_empty() {
        if !first.is_config_wrong {
            console.error("nothing was fixed: what cannot be read may be what a fix would break", None);
        }
        return Ok(Fixed::Checked(Box::new(Checked::of(project, first, console, &args.talk)), true));
    }
    // A fix may break what lies outside the paths that were named.
    let whole = Project { only: Vec::new(), ..project.clone() };
    // What is known may be fixed as well.
    let purpose = if args.fixes.unsafe_fixes { Purpose::Fixes } else { options.purpose };
    let everything = Options { baseline: BaselineChoice::Ignored, purpose, ..options.clone() };
    let check = |project: &Project, source: Box<dyn ReadSource>| input::checked(project, &everything, source, console);
    let is_whole = project.only.is_empty() && first.report.baselines.is_empty();
    let before = if is_whole { first } else { check(&whole, Box::new(DiskSource)) };
    let pasted = Pasted::of(&before.report);
    let texts: BTreeMap<_, _> = before.report.sources.files().map(|(_, file)| (&file.path, &file.text)).collect();
    let offer = |report: &Report| {
        let path = |finding: &crate::diagnostic::Diagnostic| &report.sources.file(finding.primary.span.file).path;
        let mut fixes = fix::offered(report, args.fixes.unsafe_fixes, |finding| {
            project.is_wanted(path(finding)) && !pasted.has_lost_its_sibling(report, finding)
        });
        // What a guard has taken the last use of goes with it.
        let is_new = |(_, file): &(_, &SourceFile)| texts.get(&file.path).is_some_and(|before| **before != file.text);
        let touched: BTreeSet<&PathBuf> = report.sources.files().filter(is_new).map(|(_, file)| &file.path).collect();
        fixes.extend(migrate::idle(report, &before.report, |path| touched.contains(&path.to_path_buf())));
        fixes
    };
    let mut revision =
        fix::revise(&before.report, offer, |path| bounds.file(path), |source| check(&whole, source).report);
    let names = &before.report.sources;
    if args.fixes.diff {
        revision.refuse_in_old_lines(names);
    }
    fix::keep_form(&mut revision.changes, |path, text| project.formatted(path, text));
    if args.fixes.diff {
        return Ok(Fixed::Ended(show_diff(&revision, names, printed, console)));
    }
    let written =
        fix::commit(&revision, &before.report, &mut bounds.disk(), || check(&whole, Box::new(DiskSource)).report);
    if let Err(error) = &written {
        console.error(error, None);
    }
    tell(&revision, written.is_ok(), printed, console);
    let after = input::checked(&project, options, Box::new(DiskSource), console);
    say_hidden(&after.report, &args.fixes, console);
    let failed = written.is_err() || revision.refused.iter().any(|refused| refused.is_unwritable);
    Ok(Fixed::Checked(Box::new(Checked::of(project, after, console, &args.talk)), failed))
}

/// Removes what killed runs have left, which would count as changes that are not committed.
pub(super) fn remove_abandoned(bounds: &Bounds, project: &Project, report: &Report) {
    let manifests = project.packages.iter().map(|package| package.manifest_path.as_path());
    let roots: Vec<_> = project.packages.iter().map(|package| package.workspace_root.join("Cargo.toml")).collect();
    let files = report.sources.files().map(|(_, file)| file.path.as_path());
    let files = files.chain(manifests).chain(roots.iter().map(PathBuf::as_path));
    bounds.remove_abandoned(files, std::time::SystemTime::now());
}

/// Shows what would be changed.
fn show_diff(revision: &Revision, names: &SourceMap, printed: Format, console: Console) -> ExitStatus {
    if let Format::Json(_) = printed {
        console.print(&json::fixes(revision, json::FixOutcome::WouldFix));
    } else {
        for change in &revision.changes {
            console.print(&fix::diff(change, names));
        }
        say_refused(revision, console);
    }
    match revision.made.len() {
        0 => console.say("no fix would be made"),
        made => console.say(&format!("would make {}", fixes(made))),
    }
    if revision.refused.iter().any(|refused| refused.is_unwritable) {
        ExitStatus::Incomplete
    } else if revision.changes.is_empty() {
        ExitStatus::Clean
    } else {
        ExitStatus::Findings
    }
}

/// Tells what was done, and what was not.
fn tell(revision: &Revision, is_written: bool, printed: Format, console: Console) {
    if let Format::Json(_) = printed {
        let outcome = if is_written { json::FixOutcome::Fixed } else { json::FixOutcome::NotWritten };
        console.print(&json::fixes(revision, outcome));
    }
    if is_written {
        let mut by_file: BTreeMap<&str, Vec<&fix::Fix>> = BTreeMap::new();
        for fix in &revision.made {
            by_file.entry(&fix.file).or_default().push(fix);
        }
        for (file, made) in by_file {
            console.say(&format!("fixed {file} ({})", fixes(made.len())));
            for fix in made {
                console.say(&format!("  line {}: {} (ceid::{})", fix.line, fix.title, fix.rule));
            }
        }
    }
    say_refused(revision, console);
}

fn say_refused(revision: &Revision, console: Console) {
    for refused in &revision.refused {
        let fix = &refused.fix;
        console.warn(&format!("{}:{}: not fixed (ceid::{}): {}", fix.file, fix.line, fix.rule, refused.why));
    }
}

/// Says how many fixes there are that were not asked for.
fn say_hidden(report: &Report, args: &FixArgs, console: Console) {
    let hidden = fix::offered(report, true, |_| true).into_iter().filter(|fix| fix.is_unsafe).count();
    if hidden > 0 && !args.unsafe_fixes {
        console.say(&format!(
            "note: {} may not be what was meant; `--unsafe-fixes` makes them all the same",
            fixes(hidden)
        ));
    }
}

fn fixes(number: usize) -> String {
    if number == 1 { "1 fix".to_owned() } else { format!("{number} fixes") }
}
