//! Which lines were changed since a revision, as git tells it. Writes nothing, and asks no remote.

mod diff;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use super::LoadError;

/// What was changed since a revision, in the working tree.
#[derive(Clone, Debug, Default)]
pub struct Changes {
    /// The files that have changed lines, by their paths on the disk.
    files: BTreeMap<PathBuf, Lines>,
    /// Calls that were taken away.
    pub removals: Vec<Removal>,
}

/// The changed lines of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Lines {
    /// All, for the revision does not have the file.
    All,
    /// Those of these ranges, first and last line included, in order.
    Ranges(Vec<(u32, u32)>),
}

/// Code that was taken away, with a call in it that did not come back in its place.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Removal {
    /// The file it was taken from; `None` if that is gone as well.
    pub file: Option<PathBuf>,
    /// The line behind which it stood.
    pub line: u32,
    /// All names in it.
    pub names: BTreeSet<String>,
}

impl Changes {
    /// Asks git what the working tree has changed since `revision`, untracked files included.
    ///
    /// `others` are files to look at whose names do not end as those of Rust's files do.
    ///
    /// # Errors
    /// If `root` lies in no repository, if there is no such revision, or if git cannot be run.
    pub fn since(revision: &str, root: &Path, others: &[&Path]) -> Result<Self, LoadError> {
        let root = root.canonicalize().unwrap_or_else(|_| root.to_owned());
        let Some(top) = root.ancestors().find(|above| above.join(".git").exists()) else {
            let message = format!("`{}` is not in a git repository, which `--since {revision}` needs", root.display());
            return Err(LoadError::new(message));
        };
        check_form(revision)?;
        let others = others.iter().filter_map(|path| path.strip_prefix(top).ok());
        let others = others.map(|path| format!(":(literal){}", path.to_string_lossy().replace('\\', "/")));
        let paths: Vec<String> = ["*.rs".to_owned()].into_iter().chain(others).collect();
        let paths: Vec<&str> = paths.iter().map(String::as_str).collect();
        // Nothing that the user has set for people may change what is read here.
        let flags = [
            "-U0",
            "--inter-hunk-context=0",
            "--text",
            "--find-renames",
            // A file may have moved although something else has its old name, as when `main.rs` becomes a module.
            "--break-rewrites=50%/100%",
            "--no-color",
            "--no-ext-diff",
            "--no-textconv",
            "--src-prefix=a/",
            "--dst-prefix=b/",
            "--submodule=short",
        ];
        let diff = git(top, &[&["diff"], &flags[..], &[revision, "--"], &paths].concat())?;
        if !diff.status.success() {
            return Err(refused(revision, top, &diff));
        }
        let mut changes = Self::default();
        diff::read(&String::from_utf8_lossy(&diff.stdout), top, &mut changes);
        let untracked = git(top, &[&["ls-files", "--others", "--exclude-standard", "-z", "--"], &paths[..]].concat())?;
        for name in String::from_utf8_lossy(&untracked.stdout).split('\0').filter(|name| !name.is_empty()) {
            changes.files.insert(top.join(name), Lines::All);
        }
        Ok(changes)
    }

    /// Whether a line from the first to the last one of a file was changed. The path is the one that the system has for it.
    #[must_use]
    pub fn touch(&self, file: &Path, first: u32, last: u32) -> bool {
        match self.files.get(file) {
            None => false,
            Some(Lines::All) => true,
            Some(Lines::Ranges(ranges)) => ranges.iter().any(|(start, end)| *start <= last && first <= *end),
        }
    }
}

/// Refuses what git would take for something else than one revision.
fn check_form(revision: &str) -> Result<(), LoadError> {
    if revision.is_empty() || revision.starts_with('-') {
        return Err(
            LoadError::new(format!("`{revision}` is no git revision")).help("name one, as in `--since origin/main`")
        );
    }
    if revision.contains("..") {
        let message = format!("`{revision}` is a range, and `--since` wants the revision at which it starts");
        let help = "for the point where two branches part: `--since $(git merge-base origin/main HEAD)`";
        return Err(LoadError::new(message).help(help));
    }
    // In braces stands what git searches for: `HEAD@{12:30}`, `HEAD^{/fix: gain}`; `:/text` searches as well.
    let bare = revision.split('{').next().unwrap_or_default();
    if bare.find(':').is_some_and(|at| at > 0) {
        let message =
            format!("`{revision}` is a directory or file of a revision, and `--since` wants all of the revision");
        return Err(LoadError::new(message).help("to see only some packages, add `--package NAME`"));
    }
    Ok(())
}

fn git(top: &Path, args: &[&str]) -> Result<Output, LoadError> {
    let mut command = Command::new("git");
    command.args(["-c", "core.quotepath=false"]).args(args).current_dir(top);
    for name in ["GIT_DIFF_OPTS", "GIT_LITERAL_PATHSPECS", "GIT_GLOB_PATHSPECS", "GIT_NOGLOB_PATHSPECS"] {
        command.env_remove(name);
    }
    let output = command.env("LC_ALL", "C").env("GIT_OPTIONAL_LOCKS", "0").output();
    output.map_err(|error| {
        LoadError::new(format!("cannot run `git`: {error}")).help("`--since` asks git which lines were changed")
    })
}

/// Why git did not answer.
fn refused(revision: &str, top: &Path, diff: &Output) -> LoadError {
    let is_known = git(top, &["rev-parse", "--verify", "--quiet", &format!("{revision}^{{tree}}")]);
    if is_known.is_ok_and(|it| it.status.success()) {
        let said = String::from_utf8_lossy(&diff.stderr);
        return LoadError::new(format!("`git diff {revision}` failed: {}", said.trim()));
    }
    let is_shallow = git(top, &["rev-parse", "--is-shallow-repository"]);
    let is_shallow = is_shallow.as_ref().is_ok_and(|it| it.stdout.starts_with(b"true"));
    let no_repository = is_no_repository(&diff.stderr);
    if let Some(said) = no_repository {
        return LoadError::new(format!("git cannot read the repository in `{}`: {said}", top.display()));
    }
    let error = LoadError::new(format!("there is no git revision `{revision}` in `{}`", top.display()));
    error.help(if is_shallow {
        "the clone is shallow: fetch what it lacks with `git fetch --unshallow`, or check out with `fetch-depth: 0`"
    } else {
        "`git log` shows the revisions that there are; that of a remote has to be fetched first"
    })
}

/// What git says where the fault is not the revision.
fn is_no_repository(stderr: &[u8]) -> Option<String> {
    let said = String::from_utf8_lossy(stderr);
    let said = said.trim().strip_prefix("fatal: ")?;
    (said.contains("not a git repository") || said.contains("dubious ownership")).then(|| said.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_revision_is_told() {
        let message = |text: &str| check_form(text).unwrap_err().message;
        assert_eq!(message("--output=x"), "`--output=x` is no git revision");
        assert!(message("main..HEAD").contains("is a range"));
        assert!(message("HEAD:src").contains("a directory or file of a revision"));
        assert!(
            check_form("origin/main").is_ok() && check_form("HEAD~1").is_ok() && check_form("@{1 day ago}").is_ok()
        );
    }
}
