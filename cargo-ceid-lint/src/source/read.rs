//! Where text is read: the disk, unsaved buffers, memory. Never reads a device or a file too large to be code, and reads
//! each file once a run.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use super::{FileId, SourceMap};

/// Files above this size are refused: 32 MiB, a hundred times the largest hand-written source file.
pub const MAX_FILE_BYTES: u64 = 32 * 1024 * 1024;

/// Gives the text of paths.
pub trait ReadSource: fmt::Debug + Send + Sync {
    /// The text of the file at `path`.
    ///
    /// # Errors
    /// If there is no such file, or it cannot be read as UTF-8.
    fn read(&self, path: &Path) -> Result<Arc<str>, ReadError>;

    /// Whether there is a file at `path`.
    fn exists(&self, path: &Path) -> bool;

    /// A path that is equal for two spellings of the same file.
    fn identity(&self, path: &Path) -> PathBuf {
        normalize(path)
    }

    /// The files whose text is not what the disk says.
    fn held(&self) -> Vec<PathBuf> {
        Vec::new()
    }
}

/// Why a file could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ReadError {
    /// There is none.
    NotFound,
    /// It is a directory.
    Directory,
    /// It is a device or a pipe.
    NotAFile,
    /// It has more than [`MAX_FILE_BYTES`] bytes.
    TooLarge {
        /// How many.
        bytes: u64,
    },
    /// It is text of another encoding, with two bytes a character.
    Utf16,
    /// It is not text.
    NotUtf8 {
        /// The first wrong byte, from 0.
        byte: usize,
    },
    /// Anything else, in the system's words.
    Io(String),
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFound => f.write_str("no such file"),
            Self::Directory => f.write_str("it is a directory"),
            Self::NotAFile => f.write_str("not a regular file"),
            Self::TooLarge { bytes } => write!(f, "too large to be read ({bytes} bytes, limit {MAX_FILE_BYTES})"),
            Self::Utf16 => f.write_str("not valid UTF-8: it is UTF-16"),
            Self::NotUtf8 { byte } => write!(f, "not valid UTF-8 (byte {byte})"),
            Self::Io(message) => f.write_str(message),
        }
    }
}

impl std::error::Error for ReadError {}

impl ReadError {
    /// What to do about it.
    #[must_use]
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::NotFound => "create it, or remove what names it",
            Self::Directory => "give the directory another name, or remove what names it as a file",
            Self::NotAFile => "name a regular file",
            Self::TooLarge { .. } => "split it, or take it out of the module tree",
            Self::Utf16 | Self::NotUtf8 { .. } => "save it as UTF-8, the only encoding of Rust",
            Self::Io(_) => "make it readable",
        }
    }
}

/// The disk.
#[derive(Clone, Copy, Debug, Default)]
pub struct DiskSource;

impl ReadSource for DiskSource {
    fn read(&self, path: &Path) -> Result<Arc<str>, ReadError> {
        let metadata = std::fs::metadata(path).map_err(|error| io_error(&error))?;
        if metadata.is_dir() {
            return Err(ReadError::Directory);
        }
        if !metadata.is_file() {
            return Err(ReadError::NotAFile);
        }
        if metadata.len() > MAX_FILE_BYTES {
            return Err(ReadError::TooLarge { bytes: metadata.len() });
        }
        let bytes = std::fs::read(path).map_err(|error| io_error(&error))?;
        match String::from_utf8(bytes) {
            Ok(text) => Ok(text.into()),
            Err(error) if matches!(error.as_bytes(), [0xff, 0xfe, ..] | [0xfe, 0xff, ..]) => Err(ReadError::Utf16),
            Err(error) => Err(ReadError::NotUtf8 { byte: error.utf8_error().valid_up_to() }),
        }
    }

    fn exists(&self, path: &Path) -> bool {
        // A broken or endless symbolic link counts as there, so that the message says what is wrong with it.
        std::fs::symlink_metadata(path).is_ok_and(|metadata| {
            let is_directory = if metadata.is_symlink() { path.is_dir() } else { metadata.is_dir() };
            !is_directory
        })
    }

    fn identity(&self, path: &Path) -> PathBuf {
        std::fs::canonicalize(path).unwrap_or_else(|_| normalize(path))
    }
}

/// Texts held in memory, over another source or alone.
#[derive(Debug, Default)]
pub struct MemorySource {
    texts: BTreeMap<PathBuf, Arc<str>>,
    below: Option<Box<dyn ReadSource>>,
    /// Those that were asked for: the disk follows each link of a path anew.
    identities: Mutex<BTreeMap<PathBuf, PathBuf>>,
}

impl MemorySource {
    /// Texts that hide those of `below`: unsaved buffers over the disk.
    #[must_use]
    pub fn over(below: Box<dyn ReadSource>) -> Self {
        Self { below: Some(below), ..Self::default() }
    }

    /// Adds or replaces the text of `path`.
    pub fn insert(&mut self, path: &Path, text: Arc<str>) {
        let identity = self.identity(path);
        self.texts.insert(identity, text);
    }
}

impl ReadSource for MemorySource {
    fn read(&self, path: &Path) -> Result<Arc<str>, ReadError> {
        match (self.texts.get(&self.identity(path)), &self.below) {
            (Some(text), _) => Ok(Arc::clone(text)),
            (None, Some(below)) => below.read(path),
            (None, None) => Err(ReadError::NotFound),
        }
    }

    fn exists(&self, path: &Path) -> bool {
        self.texts.contains_key(&self.identity(path)) || self.below.as_ref().is_some_and(|below| below.exists(path))
    }

    fn identity(&self, path: &Path) -> PathBuf {
        let Some(below) = &self.below else { return normalize(path) };
        let mut known = self.identities.lock().unwrap_or_else(PoisonError::into_inner);
        known.entry(path.to_owned()).or_insert_with(|| below.identity(path)).clone()
    }

    fn held(&self) -> Vec<PathBuf> {
        let below = self.below.iter().flat_map(|below| below.held());
        self.texts.keys().cloned().chain(below).collect()
    }
}

/// The files read so far and where further ones come from. A file has one [`FileId`] however often it is opened.
#[derive(Debug)]
pub struct FileSet {
    map: SourceMap,
    ids: BTreeMap<PathBuf, FileId>,
    source: Arc<dyn ReadSource>,
}

impl FileSet {
    /// An empty set that reads from `source`.
    #[must_use]
    pub fn new(map: SourceMap, source: Arc<dyn ReadSource>) -> Self {
        Self { map, ids: BTreeMap::new(), source }
    }

    /// The file at `path`, read at the first call.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn open(&mut self, path: &Path) -> Result<FileId, ReadError> {
        let identity = self.source.identity(path);
        if let Some(id) = self.ids.get(&identity) {
            return Ok(*id);
        }
        let text = self.source.read(path)?;
        let id = self.map.add(&normalize(path), text);
        self.ids.insert(identity, id);
        Ok(id)
    }

    /// Whether there is a file at `path`.
    #[must_use]
    pub fn exists(&self, path: &Path) -> bool {
        self.source.exists(path)
    }

    /// The texts read so far.
    #[must_use]
    pub fn map(&self) -> &SourceMap {
        &self.map
    }

    /// Gives the next file the number `first`: see [`SourceMap::begin`].
    pub fn begin(&mut self, first: FileId) {
        self.map.begin(first);
    }

    /// The texts, and the one path that each file has, when nothing more is to be read.
    #[must_use]
    pub fn into_parts(self) -> (SourceMap, BTreeSet<PathBuf>) {
        (self.map, self.ids.into_keys().collect())
    }

    /// The texts read so far, when nothing more is to be read.
    #[must_use]
    pub fn into_map(self) -> SourceMap {
        self.map
    }
}

fn io_error(error: &std::io::Error) -> ReadError {
    if error.kind() == std::io::ErrorKind::NotFound {
        return ReadError::NotFound;
    }
    ReadError::Io(error.to_string())
}

/// `path` without `.` and `name/..`, so that messages show the shortest spelling.
fn normalize(path: &Path) -> PathBuf {
    let mut parts: Vec<Component<'_>> = Vec::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if matches!(parts.last(), Some(Component::Normal(_))) => {
                parts.pop();
            }
            other => parts.push(other),
        }
    }
    parts.iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(path: &str, expected: &str) {
        assert_eq!(normalize(Path::new(path)), Path::new(expected));
    }

    #[test]
    fn dots_are_removed_where_they_can_be() {
        check("a/./b/../c.rs", "a/c.rs");
        check("../a.rs", "../a.rs");
        check("/../a.rs", "/../a.rs");
    }

    #[test]
    fn a_buffer_hides_the_file_below_it() {
        let mut below = MemorySource::default();
        below.insert(Path::new("a.rs"), "old".into());
        below.insert(Path::new("b.rs"), "other".into());
        let mut source = MemorySource::over(Box::new(below));
        source.insert(Path::new("./a.rs"), "new".into());
        assert_eq!(source.read(Path::new("a.rs")).as_deref(), Ok("new"));
        assert_eq!(source.read(Path::new("b.rs")).as_deref(), Ok("other"));
        assert_eq!(source.read(Path::new("c.rs")), Err(ReadError::NotFound));
    }

    #[test]
    fn a_file_has_one_id_however_it_is_spelled() {
        let mut source = MemorySource::default();
        source.insert(Path::new("src/a.rs"), "".into());
        let mut files = FileSet::new(SourceMap::default(), Arc::new(source));
        let first = files.open(Path::new("src/a.rs"));
        assert_eq!(files.open(Path::new("src/x/../a.rs")), first);
        assert_eq!(files.map().files().count(), 1);
    }

    #[test]
    fn directories_are_not_files() {
        assert_eq!(DiskSource.read(&std::env::temp_dir()), Err(ReadError::Directory));
        assert!(!DiskSource.exists(&std::env::temp_dir()));
    }
}
