//! Texts to the disk: each file is the old one or the new one in full, whenever the program is ended.

use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{Change, interrupted};
use crate::source;

/// What is done to the disk; another one than the real one is for tests.
pub trait Disk {
    /// Writes the text to a new file beside `target`, through to the device, with the permissions of `target`.
    ///
    /// # Errors
    /// The system's.
    fn stage(&mut self, target: &Path, text: &str) -> io::Result<PathBuf>;

    /// Puts the staged file in the place of `target`, at once.
    ///
    /// # Errors
    /// The system's.
    fn replace(&mut self, staged: &Path, target: &Path) -> io::Result<()>;

    /// Keeps in writing what is about to be replaced, so that a next run can tell whether this one was ended in between; `None` if
    /// nothing is kept.
    ///
    /// # Errors
    /// The system's.
    fn note(&mut self, changes: &[(&Change, &Path)]) -> io::Result<Option<PathBuf>> {
        let _ = changes;
        Ok(None)
    }
}

/// Why nothing was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WriteError {
    /// What failed.
    pub message: String,
    /// Files that had been written when it failed, and could not be put back: they have their new texts, in full.
    pub left_changed: Vec<PathBuf>,
}

impl fmt::Display for WriteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        let Some((first, others)) = self.left_changed.split_first() else {
            return f.write_str("; nothing was written");
        };
        write!(f, "; changed all the same, and complete: `{}`", first.display())?;
        others.iter().try_for_each(|path| write!(f, ", `{}`", path.display()))
    }
}

impl std::error::Error for WriteError {}

/// Writes all changes, or none: whatever goes wrong, the files that were written before it are put back.
///
/// # Errors
/// If a file is not what it was when it was read, or cannot be written.
pub fn write(changes: &[Change], disk: &mut dyn Disk) -> Result<(), WriteError> {
    let mut staged: Vec<PathBuf> = Vec::new();
    for change in changes {
        match stage(change, disk) {
            Ok(path) => staged.push(path),
            Err(message) => {
                remove(&staged);
                return Err(WriteError { message, left_changed: Vec::new() });
            }
        }
    }
    let moves: Vec<(&Change, &Path)> = changes.iter().zip(staged.iter().map(PathBuf::as_path)).collect();
    // One file alone is the old one or the new one. Without a note, everything is as safe as long as nobody ends this run.
    let note = if moves.len() > 1 { disk.note(&moves).unwrap_or(None) } else { None };
    let written = replace(changes, &staged, disk);
    if let Some(note) = note {
        remove(&[note]);
    }
    written
}

/// Puts the staged files in their places, or none.
fn replace(changes: &[Change], staged: &[PathBuf], disk: &mut dyn Disk) -> Result<(), WriteError> {
    for (number, (change, path)) in changes.iter().zip(staged).enumerate() {
        // Staging takes a while, in which somebody may have saved the file.
        let replaced = holds(&change.path, &change.old).and_then(|()| {
            let failed = |error| format!("cannot write `{}`: {error}", change.path.display());
            disk.replace(path, &change.path).map_err(failed)
        });
        if let Err(message) = replaced {
            remove(&staged[number..]);
            return Err(WriteError { message, left_changed: restore(&changes[..number], disk) });
        }
    }
    Ok(())
}

/// Gives the files the texts back that they had before `changes` were written.
///
/// # Errors
/// If one of them cannot be written, or is not what was written.
pub fn put_back(changes: &[Change], disk: &mut dyn Disk) -> Result<(), WriteError> {
    let back = |change: &Change| Change {
        path: change.path.clone(),
        old: Arc::clone(&change.new),
        new: Arc::clone(&change.old),
    };
    write(&changes.iter().map(back).collect::<Vec<_>>(), disk)
}

fn stage(change: &Change, disk: &mut dyn Disk) -> Result<PathBuf, String> {
    holds(&change.path, &change.old)?;
    let failed = |error| format!("cannot write beside `{}`: {error}", change.path.display());
    disk.stage(&change.path, &change.new).map_err(failed)
}

/// Whether a file has this text.
fn holds(path: &Path, text: &str) -> Result<(), String> {
    let now = fs::read(path).map_err(|error| format!("cannot read `{}`: {error}", path.display()))?;
    let message = || format!("`{}` was changed by somebody else since it was read", path.display());
    if now == text.as_bytes() { Ok(()) } else { Err(message()) }
}

/// Gives the old texts back, and answers which files could not be.
fn restore(written: &[Change], disk: &mut dyn Disk) -> Vec<PathBuf> {
    let mut restore = |change: &Change| {
        // What somebody else has written over it stays.
        holds(&change.path, &change.new).map_err(io::Error::other)?;
        let staged = disk.stage(&change.path, &change.old)?;
        disk.replace(&staged, &change.path).inspect_err(|_| remove(&[staged]))
    };
    let failed = written.iter().filter(|change| restore(change).is_err());
    failed.map(|change| change.path.clone()).collect()
}

fn remove(staged: &[PathBuf]) {
    for path in staged {
        // What is left behind is only in the way, and the error that is told matters more.
        let _ = fs::remove_file(path);
    }
}

/// The disk.
#[derive(Clone, Debug, Default)]
pub struct RealDisk {
    /// The directory in which it is noted what is about to be replaced, where the next run looks for that.
    pub notes: Option<PathBuf>,
}

impl Disk for RealDisk {
    fn stage(&mut self, target: &Path, text: &str) -> io::Result<PathBuf> {
        source::stage(target, text)
    }

    fn replace(&mut self, staged: &Path, target: &Path) -> io::Result<()> {
        source::replace(staged, target)
    }

    fn note(&mut self, changes: &[(&Change, &Path)]) -> io::Result<Option<PathBuf>> {
        let Some((root, text)) = self.notes.as_ref().and_then(|root| Some((root, interrupted::text(root, changes)?)))
        else {
            return Ok(None);
        };
        source::note(root, &text).map(Some)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disk that fails, or is gone, after so many replacements.
    struct Failing {
        left: usize,
        is_gone: bool,
    }

    impl Disk for Failing {
        fn stage(&mut self, target: &Path, text: &str) -> io::Result<PathBuf> {
            if self.left == 0 && self.is_gone {
                Err(io::Error::other("gone"))
            } else {
                RealDisk::default().stage(target, text)
            }
        }

        fn replace(&mut self, staged: &Path, target: &Path) -> io::Result<()> {
            if self.left == 0 {
                // Only the first one fails on a disk that stays.
                self.left = if self.is_gone { 0 } else { usize::MAX };
                return Err(io::Error::other("no space"));
            }
            self.left -= 1;
            RealDisk::default().replace(staged, target)
        }
    }

    fn directory(name: &str) -> PathBuf {
        let directory = std::env::temp_dir().join(format!("ceid-lint-write-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&directory);
        fs::create_dir_all(&directory).unwrap();
        directory
    }

    fn changes(directory: &Path) -> Vec<Change> {
        let change = |name: &str| {
            let path = directory.join(name);
            fs::write(&path, format!("old {name}")).unwrap();
            Change { path, old: format!("old {name}").into(), new: format!("new {name}").into() }
        };
        ["a", "b", "c"].map(change).to_vec()
    }

    #[track_caller]
    fn check_files(directory: &Path, expected: &[&str]) {
        let mut names: Vec<_> = fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path()).collect();
        names.sort();
        let texts: Vec<String> = names.iter().map(|path| fs::read_to_string(path).unwrap()).collect();
        assert_eq!(texts, expected);
        fs::remove_dir_all(directory).unwrap();
    }

    #[test]
    fn all_files_are_written_or_none() {
        for left in 0..3 {
            let directory = directory(&format!("none-{left}"));
            let error = write(&changes(&directory), &mut Failing { left, is_gone: false }).unwrap_err();
            assert!(error.to_string().ends_with("no space; nothing was written"), "{error}");
            check_files(&directory, &["old a", "old b", "old c"]);
        }
        let directory = directory("all");
        write(&changes(&directory), &mut RealDisk::default()).unwrap();
        check_files(&directory, &["new a", "new b", "new c"]);
    }

    #[test]
    fn what_cannot_be_put_back_is_complete_and_told() {
        let directory = directory("gone");
        let error = write(&changes(&directory), &mut Failing { left: 2, is_gone: true }).unwrap_err();
        assert_eq!(error.left_changed, [directory.join("a"), directory.join("b")]);
        check_files(&directory, &["new a", "new b", "old c"]);
    }

    #[test]
    fn what_somebody_else_wrote_stays() {
        let directory = directory("else");
        let changes = changes(&directory);
        fs::write(&changes[2].path, "mine").unwrap();
        let error = write(&changes, &mut RealDisk::default()).unwrap_err().to_string();
        assert!(error.contains("was changed by somebody else"), "{error}");
        check_files(&directory, &["old a", "old b", "mine"]);
    }

    /// A disk on which somebody saves another file as soon as the first one is replaced.
    struct Shared(PathBuf);

    impl Disk for Shared {
        fn stage(&mut self, target: &Path, text: &str) -> io::Result<PathBuf> {
            RealDisk::default().stage(target, text)
        }

        fn replace(&mut self, staged: &Path, target: &Path) -> io::Result<()> {
            fs::write(&self.0, "mine")?;
            RealDisk::default().replace(staged, target)
        }
    }

    #[test]
    fn what_somebody_else_writes_in_between_stays() {
        let directory = directory("between");
        let changes = changes(&directory);
        let error = write(&changes, &mut Shared(directory.join("c"))).unwrap_err();
        assert!(error.to_string().contains("was changed by somebody else"), "{error}");
        assert!(error.left_changed.is_empty(), "{error}");
        check_files(&directory, &["old a", "old b", "mine"]);
    }

    #[cfg(unix)]
    #[test]
    fn permissions_stay() {
        use std::os::unix::fs::PermissionsExt;
        let directory = directory("mode");
        let changes = changes(&directory);
        fs::set_permissions(&changes[0].path, fs::Permissions::from_mode(0o750)).unwrap();
        write(&changes, &mut RealDisk::default()).unwrap();
        assert_eq!(fs::metadata(&changes[0].path).unwrap().permissions().mode() & 0o777, 0o750);
        put_back(&changes, &mut RealDisk::default()).unwrap();
        assert_eq!(fs::metadata(&changes[0].path).unwrap().permissions().mode() & 0o777, 0o750);
        check_files(&directory, &["old a", "old b", "old c"]);
    }
}
