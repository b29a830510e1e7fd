//! Reads the code of a directory while it is not yet known which packages there are: cargo takes longer to say it than the disk
//! to give all bytes. What was read so is what would be read later; what was not is read then.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use memchr::memmem;
use rustc_hash::FxHashMap;

use super::files::{is_code, is_left_out, read};
use super::links::{Link, links};
use super::names::Words;

/// What the bytes of one file say, whatever is configured.
#[derive(Clone, Debug, Default)]
pub(super) struct FileFacts {
    /// Whether one of the words that matter by themselves is in it.
    pub(super) has_word: bool,
    pub(super) links: Vec<Link>,
    /// Whether it may give macros to other crates.
    pub(super) exports: bool,
    pub(super) bytes: u64,
}

impl FileFacts {
    pub(super) fn of(path: &Path, text: &[u8], has_word: bool) -> Self {
        Self { has_word, links: links(path, text), exports: exports_macros(text), bytes: text.len() as u64 }
    }
}

/// Whether a text may give macros to other crates.
pub fn exports_macros(text: &[u8]) -> bool {
    memmem::find(text, b"macro_export").is_some()
}

/// The files that were read before they were asked for.
#[derive(Debug, Default)]
pub struct ReadAhead(FxHashMap<PathBuf, FileFacts>);

impl ReadAhead {
    pub(super) fn get(&self, path: &Path) -> Option<&FileFacts> {
        self.0.get(path)
    }
}

/// A thread that reads.
#[derive(Debug)]
pub struct Reader {
    is_enough: Arc<AtomicBool>,
    worker: JoinHandle<ReadAhead>,
}

impl Reader {
    /// Begins to read what lies below the directory.
    #[must_use]
    pub fn start(directory: PathBuf) -> Self {
        let is_enough = Arc::new(AtomicBool::new(false));
        let seen = Arc::clone(&is_enough);
        Self { is_enough, worker: thread::spawn(move || read_below(directory, &seen)) }
    }

    /// Ends with what was read so far.
    #[must_use]
    pub fn stop(self) -> ReadAhead {
        self.is_enough.store(true, Ordering::Relaxed);
        // Without it everything is read later, where a panic is told.
        self.worker.join().unwrap_or_default()
    }
}

fn read_below(directory: PathBuf, is_enough: &AtomicBool) -> ReadAhead {
    let words = Words::get();
    let mut ahead = ReadAhead::default();
    let mut text = Vec::new();
    let mut open = vec![directory];
    while let Some(directory) = open.pop() {
        for entry in std::fs::read_dir(&directory).into_iter().flatten().flatten() {
            if is_enough.load(Ordering::Relaxed) {
                return ahead;
            }
            let (Ok(kind), path) = (entry.file_type(), entry.path()) else { continue };
            if kind.is_dir() {
                if !is_left_out(&path, &entry.file_name().to_string_lossy()) {
                    open.push(path);
                }
            } else if kind.is_file() && is_code(&path) && read(&path, &mut text).is_ok() {
                let facts = FileFacts::of(&path, &text, words.are_in(&text));
                ahead.0.insert(path, facts);
            }
        }
    }
    ahead
}
