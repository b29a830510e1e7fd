//! Runs that were ended while they were putting several files in their places: what belongs together is told, and brought to its end.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::{Change, Disk};
use crate::source::{self, stable_hash};

const HEADING: &str = "\
# A run of `cargo ceid-lint` was ended while it put these files in their places. `cargo ceid-lint fix` brings that to its end.";

/// A run that has changed some of the files that it wanted to change.
#[derive(Clone, Debug)]
pub struct Interrupted {
    /// Where it noted what it was about to do.
    note: PathBuf,
    /// The files that have their new texts.
    pub changed: Vec<PathBuf>,
    /// The files that have not, each with the new one beside it; `None` if that is gone, or if somebody has written the file since.
    pub unchanged: Vec<(PathBuf, Option<PathBuf>)>,
    /// The new files that were not put in their places.
    staged: Vec<PathBuf>,
}

/// What is noted of changes that are about to be made; `None` if it cannot be put in writing.
pub(super) fn text(root: &Path, changes: &[(&Change, &Path)]) -> Option<String> {
    let mut text = format!("{HEADING}\n");
    for (change, staged) in changes {
        let [staged, target] =
            [*staged, &change.path].map(|path| path.strip_prefix(root).unwrap_or(path).to_str().map(str::to_owned));
        let (staged, target) = (staged?, target?);
        if [&staged, &target].iter().any(|path| path.contains(['\t', '\n', '\r'])) {
            return None;
        }
        let [old, new] = [&change.old, &change.new].map(|text| stable_hash(text.as_bytes()));
        writeln!(text, "{old:016x}\t{new:016x}\t{staged}\t{target}").ok()?;
    }
    Some(text)
}

/// The runs that were ended in between, by what they noted in a directory.
#[must_use]
pub fn interrupted(root: &Path, now: SystemTime) -> Vec<Interrupted> {
    let notes = source::abandoned_notes(root, now).into_iter();
    // Where nothing was changed, or everything, there is nothing to be told.
    notes
        .filter_map(|note| read(root, note))
        .filter(|run| !run.changed.is_empty() && !run.unchanged.is_empty())
        .collect()
}

/// Takes away what runs noted that were ended.
pub(super) fn remove_notes(root: &Path, now: SystemTime) {
    for note in source::abandoned_notes(root, now) {
        // What is left behind is told once more.
        let _ = fs::remove_file(note);
    }
}

fn read(root: &Path, note: PathBuf) -> Option<Interrupted> {
    let text = fs::read_to_string(&note).ok()?;
    let mut run = Interrupted { note, changed: Vec::new(), unchanged: Vec::new(), staged: Vec::new() };
    let hash = |path: &Path| fs::read(path).map(|bytes| format!("{:016x}", stable_hash(&bytes))).ok();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let [old, new, staged, target] = line.split('\t').collect::<Vec<_>>().try_into().ok()?;
        let (staged, target) = (root.join(staged), root.join(target));
        let now = hash(&target);
        if now.as_deref() == Some(new) {
            run.changed.push(target);
        } else {
            run.staged.extend(source::is_staged(&staged).then(|| staged.clone()));
            let is_ready = now.as_deref() == Some(old) && hash(&staged).as_deref() == Some(new);
            run.unchanged.push((target, is_ready.then_some(staged)));
        }
    }
    Some(run)
}

impl Interrupted {
    /// Whether all that is left to do can be done.
    #[must_use]
    pub fn can_be_completed(&self) -> bool {
        self.unchanged.iter().all(|(_, staged)| staged.is_some())
    }

    /// Puts the files in their places that are not there yet.
    ///
    /// # Errors
    /// Why that could not be done to the end.
    pub fn complete(&self, disk: &mut dyn Disk) -> Result<(), String> {
        for (target, staged) in &self.unchanged {
            let failed = |why: String| format!("cannot write `{}`: {why}", target.display());
            let staged = staged.as_ref().ok_or_else(|| failed("it was changed since".to_owned()))?;
            disk.replace(staged, target).map_err(|error| failed(error.to_string()))?;
        }
        self.forget();
        Ok(())
    }

    /// Takes away what it noted and left: nothing will be done or said about it any more.
    pub fn forget(&self) {
        for staged in &self.staged {
            // What is left behind is taken away by the next run.
            let _ = fs::remove_file(staged);
        }
        // What is left behind is told once more.
        let _ = fs::remove_file(&self.note);
    }
}

#[cfg(test)]
mod tests {
    use std::io;

    use super::*;
    use crate::fix::{RealDisk, write};

    /// A disk that loses its power when a file is replaced.
    struct Dying(RealDisk, usize);

    impl Disk for Dying {
        fn stage(&mut self, target: &Path, text: &str) -> io::Result<PathBuf> {
            self.0.stage(target, text)
        }

        fn replace(&mut self, staged: &Path, target: &Path) -> io::Result<()> {
            self.1 = self.1.checked_sub(1).unwrap_or_else(|| panic!("killed"));
            self.0.replace(staged, target)
        }

        fn note(&mut self, changes: &[(&Change, &Path)]) -> io::Result<Option<PathBuf>> {
            self.0.note(changes)
        }
    }

    fn killed_after(files: usize, name: &str) -> PathBuf {
        let root = std::env::temp_dir().join(format!("ceid-lint-interrupted-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&root);
        fs::create_dir_all(root.join("src")).unwrap();
        let change = |name: &str| {
            let path = root.join(name);
            fs::write(&path, "old").unwrap();
            Change { path, old: "old".into(), new: "new".into() }
        };
        let changes = ["Cargo.toml", "src/a.rs", "src/b.rs"].map(change);
        let disk = RealDisk { notes: Some(root.clone()) };
        let run = std::panic::AssertUnwindSafe(|| write(&changes, &mut Dying(disk, files)));
        assert!(std::panic::catch_unwind(run).is_err() || files == 3);
        root
    }

    fn texts(root: &Path) -> [String; 3] {
        ["Cargo.toml", "src/a.rs", "src/b.rs"].map(|name| fs::read_to_string(root.join(name)).unwrap())
    }

    #[test]
    fn what_was_begun_is_brought_to_its_end() {
        for files in 1..3 {
            let root = killed_after(files, &format!("end-{files}"));
            let [run] = interrupted(&root, SystemTime::now()).try_into().unwrap();
            assert_eq!((run.changed.len(), run.unchanged.len()), (files, 3 - files));
            run.complete(&mut RealDisk::default()).unwrap();
            assert_eq!(texts(&root), ["new", "new", "new"]);
            assert_eq!(fs::read_dir(&root).unwrap().count() + fs::read_dir(root.join("src")).unwrap().count(), 4);
            fs::remove_dir_all(root).unwrap();
        }
    }

    #[test]
    fn nothing_is_told_of_a_run_that_changed_nothing_or_everything() {
        for files in [0, 3] {
            let root = killed_after(files, &format!("all-{files}"));
            assert!(interrupted(&root, SystemTime::now()).is_empty());
            remove_notes(&root, SystemTime::now());
            assert!(source::abandoned_notes(&root, SystemTime::now()).is_empty());
            fs::remove_dir_all(root).unwrap();
        }
    }

    #[test]
    fn what_somebody_has_written_since_stays() {
        let root = killed_after(1, "since");
        fs::write(root.join("src/b.rs"), "mine").unwrap();
        let [run] = interrupted(&root, SystemTime::now()).try_into().unwrap();
        assert!(!run.can_be_completed());
        assert_eq!(texts(&root), ["new", "old", "mine"]);
        fs::remove_dir_all(root).unwrap();
    }
}
