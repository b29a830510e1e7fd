//! Texts with edits made in them. Reads a file only where no check has read it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{Edit, Fix};
use crate::source::{DiskSource, MemorySource, ReadSource, SourceMap};

/// A file before and after.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// The file itself, with no symbolic link on the way to it.
    pub path: PathBuf,
    /// Its text before the first fix.
    pub old: Arc<str>,
    /// Its text after the last one.
    pub new: Arc<str>,
}

/// The files that were changed so far, by their real paths.
#[derive(Clone, Debug, Default)]
pub struct Texts(BTreeMap<PathBuf, Change>);

impl Texts {
    /// The files whose texts are others than before, by path.
    #[must_use]
    pub fn changes(&self) -> Vec<Change> {
        self.0.values().filter(|change| change.old != change.new).cloned().collect()
    }

    /// The disk with these texts over it.
    #[must_use]
    pub fn source(&self) -> Box<dyn ReadSource> {
        let mut source = MemorySource::over(Box::new(DiskSource));
        for change in self.0.values() {
            source.insert(&change.path, Arc::clone(&change.new));
        }
        Box::new(source)
    }

    /// The text of a file as it is now: after the fixes so far, as the check has read it, or as it lies on the disk.
    pub(super) fn text(&self, path: &Path, sources: &SourceMap) -> Result<Arc<str>, String> {
        if let Some(change) = self.0.get(path) {
            return Ok(Arc::clone(&change.new));
        }
        let is_it = |read: &Path| read == path || read.canonicalize().is_ok_and(|real| real == path);
        match sources.files().find(|(_, file)| is_it(&file.path)) {
            Some((_, file)) => Ok(Arc::clone(&file.text)),
            None => DiskSource.read(path).map_err(|error| error.to_string()),
        }
    }

    /// These texts with the edits of all `fixes`, which do not overlap and whose places are those of [`Texts::text`].
    pub(super) fn with(&self, fixes: &[Fix], sources: &SourceMap) -> Result<Self, String> {
        let mut edits: BTreeMap<&Path, BTreeSet<&Edit>> = BTreeMap::new();
        for edit in fixes.iter().flat_map(|fix| &fix.edits) {
            edits.entry(&edit.path).or_default().insert(edit);
        }
        let mut texts = self.clone();
        for (path, edits) in edits {
            let before = self.text(path, sources)?;
            let mut text = before.to_string();
            // From the last to the first, so that the places of the others stay right.
            for edit in edits.into_iter().rev() {
                if text.get(edit.start..edit.end).is_none() {
                    return Err(format!("`{}` has no bytes {} to {}", path.display(), edit.start, edit.end));
                }
                text.replace_range(edit.start..edit.end, &edit.text);
            }
            let old = self.0.get(path).map_or(before, |change| Arc::clone(&change.old));
            texts.0.insert(path.to_owned(), Change { path: path.to_owned(), old, new: text.into() });
        }
        Ok(texts)
    }
}

impl Edit {
    /// Whether the two cannot both be made. Equal ones can: they are made once.
    pub(super) fn is_against(&self, other: &Self) -> bool {
        let meet = self.start < other.end && other.start < self.end || self.start == other.start;
        self != other && self.path == other.path && meet
    }
}

impl Fix {
    /// Whether the two cannot both be made from the same texts.
    pub(super) fn is_against(&self, other: &Self) -> bool {
        self.edits.iter().any(|edit| other.edits.iter().any(|their| edit.is_against(their)))
    }

    /// Whether its own edits cannot all be made.
    pub(super) fn is_against_itself(&self) -> bool {
        self.is_against(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edit(start: usize, end: usize, text: &str) -> Edit {
        Edit { path: "/a.rs".into(), start, end, text: text.to_owned() }
    }

    fn fix(edits: &[Edit]) -> Fix {
        Fix {
            rule: "repeated_update",
            title: String::new(),
            file: String::new(),
            line: 1,
            is_unsafe: false,
            edits: edits.to_vec(),
        }
    }

    fn sources(text: &str) -> SourceMap {
        let mut sources = SourceMap::default();
        sources.add(Path::new("/a.rs"), text.into());
        sources
    }

    #[track_caller]
    fn check(text: &str, fixes: &[Fix], expected: &str) {
        let texts = Texts::default().with(fixes, &sources(text)).unwrap();
        assert_eq!(&*texts.changes()[0].new, expected);
    }

    #[test]
    fn places_are_those_before_all_edits() {
        check("a b c", &[fix(&[edit(0, 1, "long"), edit(4, 5, "")]), fix(&[edit(2, 3, "é")])], "long é ");
    }

    #[test]
    fn equal_edits_are_made_once() {
        check("x", &[fix(&[edit(0, 0, "use a;\n")]), fix(&[edit(0, 0, "use a;\n")])], "use a;\nx");
    }

    #[test]
    fn two_edits_meet_where_the_order_would_matter() {
        let first = edit(2, 5, "");
        for (other, meets) in [
            (edit(2, 5, ""), false),
            (edit(2, 5, "x"), true),
            (edit(4, 9, ""), true),
            (edit(5, 9, ""), false),
            (edit(0, 2, ""), false),
            (edit(2, 2, "x"), true),
            (edit(5, 5, "x"), false),
        ] {
            assert_eq!(first.is_against(&other), meets, "{other:?}");
            assert_eq!(other.is_against(&first), meets, "{other:?}");
        }
        assert!(fix(&[edit(0, 3, ""), edit(1, 2, "")]).is_against_itself());
    }

    #[test]
    fn a_place_that_is_not_there_changes_nothing() {
        assert!(Texts::default().with(&[fix(&[edit(1, 2, "")])], &sources("é")).is_err());
        assert!(Texts::default().with(&[fix(&[edit(7, 9, "")])], &sources("a")).is_err());
    }

    #[test]
    fn what_was_there_first_is_remembered() {
        let sources = sources("a b");
        let once = Texts::default().with(&[fix(&[edit(0, 1, "x")])], &sources).unwrap();
        let twice = once.with(&[fix(&[edit(2, 3, "y")])], &sources).unwrap();
        let change = &twice.changes()[0];
        assert_eq!((&*change.old, &*change.new), ("a b", "x y"));
    }
}
