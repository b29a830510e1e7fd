//! What is said and done about runs that were ended when they had written some of the files that belong together.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::{Console, input};
use crate::fix::{Bounds, Interrupted};
use crate::project::Project;

/// Tells of them, and what to do.
pub(super) fn tell(project: &Project, console: Console) {
    for run in Bounds::of(project).interrupted(SystemTime::now()) {
        let what = half(&run);
        console.warn(&match run.can_be_completed() {
            true => format!("{what}; `cargo ceid-lint fix` brings that to its end"),
            false => format!("{what}; {}", by_hand(&run)),
        });
    }
}

/// Brings them to their end, and says so; whether there were any, so that what was loaded is another text by now.
pub(super) fn complete(bounds: &Bounds, console: Console) -> bool {
    let runs = bounds.interrupted(SystemTime::now());
    for run in &runs {
        let completed = if run.can_be_completed() { run.complete(&mut bounds.disk()) } else { Err(by_hand(run)) };
        match completed {
            Ok(()) => console.error(
                &format!("{}: that is done now", half(run)),
                Some("look at these changes, commit them or take them back, and run it again"),
            ),
            Err(why) => {
                console.error(&format!("{}; {why}", half(run)), None);
                run.forget();
            }
        }
    }
    !runs.is_empty()
}

fn half(run: &Interrupted) -> String {
    let left = run.unchanged.iter().map(|(path, _)| path);
    format!(
        "a run was ended when it had written {}, and not {}, which belong together",
        names(run.changed.iter()),
        names(left)
    )
}

fn by_hand(run: &Interrupted) -> String {
    format!("what was to be written is gone: take the changes of {} back", names(run.changed.iter()))
}

/// How many files are named before it is said how many more there are.
const MOST_NAMES: usize = 6;

fn names<'p>(paths: impl Iterator<Item = &'p PathBuf>) -> String {
    let current = std::env::current_dir().and_then(|current| current.canonicalize()).unwrap_or_default();
    let shown = |path: &'p PathBuf| path.strip_prefix(&current).map_or(path.as_path(), Path::new);
    let names: Vec<String> = paths.map(|path| format!("`{}`", input::shown(shown(path)))).collect();
    match names.len().checked_sub(MOST_NAMES) {
        Some(more) if more > 0 => format!("{} and {more} more", names[..MOST_NAMES].join(", ")),
        _ => names.join(", "),
    }
}
