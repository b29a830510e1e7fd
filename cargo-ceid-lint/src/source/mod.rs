//! Text and places in it: which files were read, where a byte is, how a place is shown. Knows no syntax.

mod line_index;
mod percent;
mod read;
mod stable_hash;

use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use line_index::{LineColumn, LineIndex};
pub use percent::percent_encoded;
pub use read::{DiskSource, FileSet, MAX_FILE_BYTES, MemorySource, ReadError, ReadSource};
pub use stable_hash::stable_hash;

/// A file of a [`SourceMap`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FileId(pub u32);

/// A byte range in one file; `start` is inclusive, `end` is exclusive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Span {
    /// The file.
    pub file: FileId,
    /// The first byte.
    pub start: u32,
    /// The byte behind the last one.
    pub end: u32,
}

impl Span {
    /// The range from `start` to `end` of `file`.
    #[must_use]
    pub fn new(file: FileId, start: u32, end: u32) -> Self {
        Self { file, start, end: end.max(start) }
    }

    /// The smallest range that holds both; `self` if they lie in different files.
    #[must_use]
    pub fn to(self, other: Self) -> Self {
        if self.file == other.file {
            Self { file: self.file, start: self.start.min(other.start), end: self.end.max(other.end) }
        } else {
            self
        }
    }

    /// Whether `other` lies inside this range.
    #[must_use]
    pub fn contains(self, other: Self) -> bool {
        self.file == other.file && self.start <= other.start && other.end <= self.end
    }
}

/// A text that was read, with the path it is shown under.
#[derive(Clone, Debug)]
pub struct SourceFile {
    /// Where the file lies on the disk.
    pub path: PathBuf,
    /// The path shown to users: relative to the workspace root where possible, with `/`.
    pub name: String,
    /// The whole text.
    pub text: Arc<str>,
    /// Where its lines begin.
    pub lines: LineIndex,
}

/// All files of a run, in the order they were read.
#[derive(Clone, Debug, Default)]
pub struct SourceMap {
    files: Vec<SourceFile>,
    root: PathBuf,
}

impl SourceMap {
    /// An empty map whose files are shown relative to `root`.
    #[must_use]
    pub fn new(root: PathBuf) -> Self {
        Self { files: Vec::new(), root }
    }

    /// Adds a file that was read from `path`.
    ///
    /// # Panics
    /// After 2^32 files.
    pub fn add(&mut self, path: &Path, text: Arc<str>) -> FileId {
        let id = FileId(u32::try_from(self.files.len()).expect("fewer than 2^32 files"));
        let name = self.display_name(path);
        let lines = LineIndex::new(&text);
        self.files.push(SourceFile { path: path.to_owned(), name, text, lines });
        id
    }

    /// The path as it is shown to users: relative to the root where possible, with `/`.
    #[must_use]
    pub fn display_name(&self, path: &Path) -> String {
        let relative = path.strip_prefix(&self.root).unwrap_or(path);
        relative.to_string_lossy().replace('\\', "/")
    }

    /// The file of this map with that id.
    ///
    /// # Panics
    /// If the id comes from another map.
    #[must_use]
    pub fn file(&self, id: FileId) -> &SourceFile {
        &self.files[id.0 as usize]
    }

    /// All files with their ids.
    pub fn files(&self) -> impl Iterator<Item = (FileId, &SourceFile)> {
        (0u32..).map(FileId).zip(&self.files)
    }

    /// The text of a place.
    #[must_use]
    pub fn snippet(&self, span: Span) -> &str {
        self.file(span.file).text.get(span.start as usize..span.end as usize).unwrap_or("")
    }

    /// Line and column of the first byte of a place.
    #[must_use]
    pub fn position(&self, span: Span) -> LineColumn {
        let file = self.file(span.file);
        file.lines.line_column(&file.text, span.start)
    }

    /// The 1-based line of the first byte of a place.
    #[must_use]
    pub fn line(&self, span: Span) -> u32 {
        self.position(span).line
    }
}
