//! Whether what is about to be changed can be got back: the question that `cargo fix` asks of the version control, in its words.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use super::args::FixArgs;
use crate::source::is_staged;

/// What `git status` tells of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Dirty,
    Staged,
}

/// Refuses where there is no version control, or where changes in the repository are not committed.
///
/// cargo asks about the directory that it is called in; this asks about `root`, the workspace that is changed.
///
/// # Errors
/// What to tell the user.
pub(super) fn check(root: &Path, args: &FixArgs) -> Result<(), String> {
    if args.allow_no_vcs {
        return Ok(());
    }
    if !is_in_git(root)? {
        return if is_in_mercurial(root) { Ok(()) } else { Err(NO_VCS.to_owned()) };
    }
    if args.allow_dirty {
        return Ok(());
    }
    let mut dirty = Vec::new();
    let mut staged = Vec::new();
    let mut changed = status(root)?;
    // What a killed run of another machine or container has left stands beside the sources, and changes none of them.
    changed.retain(|(_, path)| !is_staged(Path::new(path)));
    for (state, path) in changed {
        match state {
            State::Dirty => dirty.push(format!("  * {path} (dirty)\n")),
            State::Staged if args.allow_staged => {}
            State::Staged => staged.push(format!("  * {path} (staged)\n")),
        }
    }
    if dirty.is_empty() && staged.is_empty() {
        return Ok(());
    }
    dirty.append(&mut staged);
    Err(format!("{UNCOMMITTED}\n\n{}", dirty.concat()))
}

const NO_VCS: &str = "no VCS found for this package and `cargo ceid-lint fix` can potentially perform destructive changes; \
     if you'd like to suppress this error pass `--allow-no-vcs`";

const UNCOMMITTED: &str = "the working directory of this package has uncommitted changes, and `cargo ceid-lint fix` can \
     potentially perform destructive changes; if you'd like to suppress this error pass `--allow-dirty`, or commit the \
     changes to these files:";

/// Whether a repository of git keeps the directory. One that is ignored is not kept.
fn is_in_git(root: &Path) -> Result<bool, String> {
    let has_marker = || root.ancestors().any(|above| above.join(".git").exists());
    let unknown = |why: &str| {
        format!(
            "git cannot tell whether there are uncommitted changes: {why}; `--allow-no-vcs` goes on without asking it"
        )
    };
    let found = match git(root, &["rev-parse", "--show-toplevel"]) {
        Ok(found) => found,
        Err(error) if has_marker() => return Err(unknown(&error)),
        Err(_) => return Ok(false),
    };
    if !found.status.success() {
        let said = String::from_utf8_lossy(&found.stderr);
        return if has_marker() { Err(unknown(said.trim())) } else { Ok(false) };
    }
    let top = String::from_utf8_lossy(&found.stdout).trim_end_matches(['\n', '\r']).to_owned();
    if Path::new(&top) == root {
        return Ok(true);
    }
    let ignored = git(root, &["check-ignore", "--quiet", "."]).map_err(|error| unknown(&error))?;
    Ok(!ignored.status.success())
}

fn is_in_mercurial(root: &Path) -> bool {
    let found = Command::new("hg").arg("--cwd").arg(root).arg("root").stdin(Stdio::null()).output();
    found.is_ok_and(|output| output.status.success())
}

/// The files of the repository that are not as they were committed.
fn status(root: &Path) -> Result<Vec<(State, String)>, String> {
    let output = git(root, &["status", "--porcelain", "-z", "--no-renames", "--untracked-files=normal"])?;
    if !output.status.success() {
        return Err(format!("`git status` failed: {}", String::from_utf8_lossy(&output.stderr).trim()));
    }
    Ok(String::from_utf8_lossy(&output.stdout).split('\0').filter_map(entry).collect())
}

/// An entry of `git status --porcelain -z`: two letters for the index and the working directory, a space, and the path.
fn entry(text: &str) -> Option<(State, String)> {
    let (letters, path) = text.split_at_checked(3)?;
    let is_only_in_index = !letters.starts_with([' ', '?']) && letters[1..].starts_with(' ');
    Some((if is_only_in_index { State::Staged } else { State::Dirty }, path.to_owned()))
}

fn git(root: &Path, args: &[&str]) -> Result<Output, String> {
    let mut git = Command::new("git");
    // A hook of git names the repository that it runs for, which need not be this one.
    git.args(args).current_dir(root).stdin(Stdio::null()).env_remove("GIT_DIR").env_remove("GIT_WORK_TREE");
    git.env_remove("GIT_INDEX_FILE").env("GIT_OPTIONAL_LOCKS", "0");
    git.output().map_err(|error| format!("cannot run `git`: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: Option<(State, &str)>) {
        assert_eq!(entry(text), expected.map(|(state, path)| (state, path.to_owned())));
    }

    #[test]
    fn what_is_in_the_index_alone_is_staged() {
        check("M  src/a b.rs", Some((State::Staged, "src/a b.rs")));
        check("A  ü.rs", Some((State::Staged, "ü.rs")));
        check("MM src/a.rs", Some((State::Dirty, "src/a.rs")));
        check(" M src/a.rs", Some((State::Dirty, "src/a.rs")));
        check("?? new/", Some((State::Dirty, "new/")));
        check("UU src/a.rs", Some((State::Dirty, "src/a.rs")));
        check("", None);
    }
}
