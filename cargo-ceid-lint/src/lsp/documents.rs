//! The texts that are open in the editor, saved or not.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::protocol::Change;
use super::text::{Encoding, Lines};
use super::uri;
use crate::source::{DiskSource, ReadSource};

/// An open text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Document {
    /// Its address as the client spells it.
    pub(super) uri: String,
    /// The client's number of its state.
    pub(super) version: i64,
    /// The whole text.
    pub(super) text: Arc<str>,
}

/// All open texts, by the identities of their files.
#[derive(Clone, Debug, Default)]
pub(super) struct Documents {
    open: BTreeMap<PathBuf, Document>,
    /// The identities of open files, by their addresses: one that was deleted keeps the one it had.
    identities: BTreeMap<String, PathBuf>,
}

/// A path that is equal for all spellings of a file, and of a file that is not there.
pub(super) fn identity(path: &Path) -> PathBuf {
    let own = DiskSource.identity(path);
    if own.exists() {
        return own;
    }
    // The directory is perhaps a link, although the file is not there.
    match (path.parent(), path.file_name()) {
        (Some(directory), Some(name)) => DiskSource.identity(directory).join(name),
        _ => own,
    }
}

impl Documents {
    /// Opens a text, and answers the file that it is; none if it is no file.
    pub(super) fn open(&mut self, uri: String, version: i64, text: String) -> Option<PathBuf> {
        let path = identity(&uri::to_path(&uri)?);
        self.identities.insert(uri.clone(), path.clone());
        self.open.insert(path.clone(), Document { uri, version, text: text.into() });
        Some(path)
    }

    /// Changes an open text, and answers the file that it is.
    ///
    /// # Errors
    /// If it is not open.
    pub(super) fn change(
        &mut self,
        uri: &str,
        version: Option<i64>,
        changes: Vec<Change>,
        encoding: Encoding,
    ) -> Result<PathBuf, String> {
        let path = self.identities.get(uri);
        let Some((path, document)) = path.and_then(|path| Some((path, self.open.get_mut(path)?))) else {
            return Err(format!("`{uri}` is changed, and it is not open"));
        };
        let mut text = String::from(&*document.text);
        for change in changes {
            match change.range {
                None => text = change.text,
                Some(range) => {
                    let bytes = Lines::new(&text).bytes_of(range, encoding);
                    text.replace_range(bytes, &change.text);
                }
            }
        }
        document.text = text.into();
        document.version = version.unwrap_or(document.version);
        Ok(path.clone())
    }

    /// Closes a text, and answers the file that it is.
    pub(super) fn close(&mut self, uri: &str) -> Option<PathBuf> {
        let path = self.identities.remove(uri)?;
        self.open.remove(&path)?;
        Some(path)
    }

    pub(super) fn get(&self, path: &Path) -> Option<&Document> {
        self.open.get(path)
    }

    /// The open texts with their files.
    pub(super) fn iter(&self) -> impl Iterator<Item = (&PathBuf, &Document)> {
        self.open.iter()
    }

    /// The file that an address means, open or not.
    pub(super) fn path_of(&self, uri: &str) -> Option<PathBuf> {
        self.identities.get(uri).cloned().or_else(|| uri::to_path(uri).map(|path| identity(&path)))
    }

    /// The address of a file, as the client spells it if it does.
    pub(super) fn uri_of(&self, path: &Path) -> String {
        self.open.get(path).map_or_else(|| uri::of_path(path), |document| document.uri.clone())
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::super::protocol::{Position, Range};
    use super::*;

    const URI: &str = "file:///nowhere/%C3%A9.rs";

    fn opened(text: &str) -> Documents {
        let mut documents = Documents::default();
        assert_eq!(documents.open(URI.to_owned(), 1, text.to_owned()), Some("/nowhere/é.rs".into()));
        documents
    }

    fn change(range: Option<[u32; 4]>, text: &str) -> Change {
        let range = range.map(|[line, character, end_line, end_character]| Range {
            start: Position { line, character },
            end: Position { line: end_line, character: end_character },
        });
        Change { range, text: text.to_owned() }
    }

    #[track_caller]
    fn check(text: &str, changes: Vec<Change>, expected: &str) {
        let mut documents = opened(text);
        let path = documents.change(URI, Some(2), changes, Encoding::Utf16).expect("it is open");
        let document = documents.get(&path).expect("it is open");
        assert_eq!((&*document.text, document.version), (expected, 2));
    }

    #[test]
    fn changes_are_made_in_their_order() {
        check("a𝛼b\nc", vec![change(Some([0, 3, 0, 4]), "é"), change(Some([1, 0, 1, 1]), "")], "a𝛼é\n");
        check("a", vec![change(Some([0, 1, 0, 1]), "b"), change(None, "x\n"), change(Some([1, 0, 1, 0]), "y")], "x\ny");
    }

    #[test]
    fn places_that_are_not_there_are_moved_inside() {
        check("ab", vec![change(Some([7, 7, 9, 9]), "c")], "abc");
        check("ab", vec![change(Some([0, 2, 0, 1]), "c")], "abc");
    }

    #[test]
    fn only_open_texts_can_be_changed() {
        let mut documents = opened("a");
        assert!(documents.close(URI).is_some() && documents.close(URI).is_none());
        assert!(documents.change(URI, None, Vec::new(), Encoding::Utf16).is_err());
        assert_eq!(documents.open("untitled:1".to_owned(), 1, String::new()), None);
    }
}
