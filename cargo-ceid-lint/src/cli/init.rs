//! `cargo ceid-lint init`: a first `ceid-lint.toml`.

use std::path::Path;
use std::time::Instant;

use super::args::InitArgs;
use super::{Console, ExitStatus, input};
use crate::config::FILE_NAME;
use crate::draft::{self, Accept, Draft};
use crate::pipeline::{self, Prospect};
use crate::project::Project;
use crate::report::count;

/// Looks, and writes the file beside the manifest of each workspace.
///
/// # Errors
/// What is wrong with the arguments.
pub(super) fn run(args: &InitArgs) -> Result<ExitStatus, String> {
    let console = Console::new(&args.talk);
    let mut selection = input::selection(&args.paths, &args.scope, &args.build);
    // The file is for the whole workspace, whatever its default members are.
    selection.workspace |= selection.packages.is_empty();
    let Ok(project) = input::project(&selection, console, Instant::now()) else { return Ok(ExitStatus::Incomplete) };
    let has_manifest = |root: &Path| root.join("Cargo.toml").is_file();
    let roots = project.packages.iter().filter(|package| package.is_reported).map(|package| &package.workspace_root);
    if let Some(root) = roots.clone().find(|root| !args.force && !args.stdout && root.join(FILE_NAME).exists()) {
        console.error(
            &format!("`{}` is already there", input::shown(&root.join(FILE_NAME))),
            Some("`--stdout` prints what would be written; `--force` writes over it, and what was changed by hand is lost"),
        );
        return Ok(ExitStatus::Incomplete);
    }
    if !args.stdout && !roots.clone().any(|root| has_manifest(root)) {
        let (message, help) = match roots.clone().next() {
            Some(_) => ("there is no manifest beside which the file could stand", "`--stdout` prints it"),
            None => (
                "no target is selected, so that there is no code to look at",
                "`--all-targets` and `--all-features` take all of it",
            ),
        };
        console.error(message, Some(help));
        return Ok(ExitStatus::Incomplete);
    }
    let prospect = match pipeline::prospect(&project) {
        Ok(prospect) => prospect,
        Err(error) => {
            console.error(&error.message, error.help.as_deref());
            return Ok(ExitStatus::Incomplete);
        }
    };
    let accept = match &args.accept {
        None => Accept::Certain,
        Some(names) if names.iter().any(|name| name == "all") => Accept::All,
        Some(names) => Accept::Named(names.clone()),
    };
    let found: Vec<_> = prospect.workspaces.values().collect();
    if let Some((name, near)) = accept.unknown(&found) {
        let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
        return Err(format!("nothing called `{name}` was found{near}"));
    }
    let mut status = ExitStatus::Clean;
    for (root, candidates) in &prospect.workspaces {
        let flags = flags(&project, root);
        let draft = draft::write(candidates, &prospect.presets, &prospect.sources, root, &accept, flags);
        let path = root.join(FILE_NAME);
        if args.stdout {
            console.print(&draft.text);
        } else if let Err(error) = std::fs::write(&path, &draft.text) {
            console.error(&format!("cannot write `{}`: {error}", input::shown(&path)), None);
            status = ExitStatus::Incomplete;
        } else {
            console.say(&said(&path, &draft, flags));
        }
    }
    say_problems(&project.problems, &prospect, console);
    if project.problems.iter().chain(&prospect.problems).any(|problem| problem.is_error) {
        status = ExitStatus::Incomplete;
    }
    Ok(status)
}

/// What a run needs to check all that the file is for: cargo's own choice may leave members out.
fn flags(project: &Project, root: &Path) -> &'static str {
    let mut packages = project.packages.iter().filter(|package| package.is_reported && package.workspace_root == *root);
    if packages.all(|package| package.is_default) { "" } else { " --workspace" }
}

/// What was written, and what to do next.
fn said(path: &Path, draft: &Draft, flags: &str) -> String {
    let Draft { filters_on, filters, cycles_on, cycles, .. } = *draft;
    let path = input::shown(path);
    if filters + cycles == 0 {
        return format!(
            "wrote `{path}`: nothing was found that looks like a filter and is not known as one; the file says how to name one"
        );
    }
    let mut said = format!("wrote `{path}`: {}, {filters_on} turned on", count(filters, "likely filter"));
    if cycles > 0 {
        said += &format!("; {}, {cycles_on} turned on", count(cycles, "likely cycle function"));
    }
    if filters_on + cycles_on < filters + cycles {
        said += &format!("\nremove the `#` of those that are right, then run `cargo ceid-lint{flags}`");
    } else {
        said += &format!("\nnow run `cargo ceid-lint{flags}`");
    }
    said
}

fn say_problems(problems: &[crate::diagnostic::Problem], prospect: &Prospect, console: Console) {
    let unread = problems.len() + prospect.problems.len();
    if unread > 0 {
        console.warn(&format!(
            "{} could not be read, so that filters may be missing; `cargo ceid-lint` says what and why",
            count(unread, "place")
        ));
    }
}
