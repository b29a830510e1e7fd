//! Text and places in it: which files were read, where a byte is, how a place is shown. Knows no syntax.

mod line_index;
mod percent;
mod read;
mod stable_hash;
mod write;

use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use line_index::{LineColumn, LineIndex};
pub use percent::{file_url, percent_encoded};
pub use read::{DiskSource, FileSet, MAX_FILE_BYTES, MemorySource, ReadError, ReadSource};
pub use stable_hash::stable_hash;
pub use write::{abandoned_notes, is_staged, note, remove_abandoned, replace, stage, write};

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
    /// How many lines and bytes it has, if the text was dropped.
    dropped: Option<(u32, usize)>,
}

impl SourceFile {
    /// How many lines the file has.
    #[must_use]
    pub fn line_count(&self) -> u32 {
        self.dropped.map_or_else(|| self.lines.count(&self.text), |(lines, _)| lines)
    }

    /// How many bytes the file has.
    #[must_use]
    pub fn byte_count(&self) -> usize {
        self.dropped.map_or(self.text.len(), |(_, bytes)| bytes)
    }
}

/// All files of a run. They have numbers in the order in which they were added, in ranges that begin where it was said: what is
/// read side by side has a range for each part, so that the numbers do not tell which part was faster.
#[derive(Clone, Debug, Default)]
pub struct SourceMap {
    /// By their first numbers.
    ranges: Vec<FileRange>,
    /// The first number of the range that files are added to.
    open: u32,
    root: PathBuf,
}

/// Files with numbers in a row.
#[derive(Clone, Debug)]
struct FileRange {
    first: u32,
    files: Vec<SourceFile>,
}

impl SourceMap {
    /// An empty map whose files are shown relative to `root`.
    #[must_use]
    pub fn new(root: PathBuf) -> Self {
        Self { ranges: Vec::new(), open: 0, root }
    }

    /// Gives the next file the number `first`, and those behind it the numbers from there on, which no file has.
    pub fn begin(&mut self, first: FileId) {
        self.open = first.0;
        let at = self.behind(first);
        self.ranges.insert(at, FileRange { first: first.0, files: Vec::new() });
    }

    /// How many ranges begin at that number or before it.
    fn behind(&self, id: FileId) -> usize {
        self.ranges.partition_point(|range| range.first <= id.0)
    }

    /// Adds the files of another map, whose ranges lie apart from those of this one.
    pub fn extend(&mut self, other: Self) {
        self.ranges.extend(other.ranges);
        self.ranges.sort_by_key(|range| range.first);
    }

    /// Forgets the texts of which nothing will be shown.
    pub fn drop_texts(&mut self, is_dropped: impl Fn(FileId) -> bool) {
        let files = self.ranges.iter_mut().flat_map(|range| (range.first..).map(FileId).zip(&mut range.files));
        for (_, file) in files.filter(|(id, _)| is_dropped(*id)) {
            file.dropped = Some((file.line_count(), file.byte_count()));
            file.text = Arc::from("");
            file.lines = LineIndex::default();
        }
    }

    /// Adds a file that was read from `path`.
    ///
    /// # Panics
    /// After 2^32 files.
    pub fn add(&mut self, path: &Path, text: Arc<str>) -> FileId {
        let name = self.display_name(path);
        if self.ranges.is_empty() {
            self.begin(FileId(0));
        }
        let open = self.behind(FileId(self.open));
        let range = self.ranges[..open].last_mut().expect("a range was begun");
        let number = u32::try_from(range.files.len()).expect("fewer than 2^32 files");
        range.files.push(SourceFile { path: path.to_owned(), name, text, lines: LineIndex::default(), dropped: None });
        FileId(range.first + number)
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
        self.get(id).expect("the id comes from this map")
    }

    /// The file with that id, if it comes from this map.
    #[must_use]
    pub fn get(&self, id: FileId) -> Option<&SourceFile> {
        let range = self.ranges[..self.behind(id)].last()?;
        range.files.get((id.0 - range.first) as usize)
    }

    /// All files with their ids.
    pub fn files(&self) -> impl Iterator<Item = (FileId, &SourceFile)> {
        self.ranges.iter().flat_map(|range| (range.first..).map(FileId).zip(&range.files))
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
        let file = self.file(span.file);
        file.lines.line(&file.text, span.start)
    }
}
