//! Changes to the user's files that lose nothing: which of the offered fixes can be made, and the writing of what they leave.
//!
//! [`revise`] works on texts in memory: it takes the fixes that are offered, leaves out those that overlap with another one until
//! the next round, checks the whole again with the changed texts, and takes back each fix that brings something new to light.
//! [`commit`] then brings the texts to the disk, each file in full or not at all, checks what lies there, and puts all of it back
//! if that is not what was promised. Between the two a caller may still look at the [`Revision`], or show it with [`diff()`].
//!
//! Prints nothing, and knows no rule: what a fix changes was decided when it was offered.

mod bounds;
mod commit;
mod diff;
mod edits;
mod form;
mod interrupted;
mod news;
mod offers;
mod revise;
mod write;

use std::path::PathBuf;

pub use bounds::Bounds;
pub use commit::commit;
pub use diff::diff;
pub use edits::{Change, Texts};
pub use form::keep_form;
pub use interrupted::{Interrupted, interrupted};
pub use news::{News, news};
pub use offers::{Pasted, offered};
pub use revise::{Refused, Revision, UNUSED_SUPPRESSION, revise};
pub use write::{Disk, RealDisk, WriteError, put_back, write};

/// A change to one place of one file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Edit {
    /// The file.
    pub path: PathBuf,
    /// The first byte that is replaced.
    pub start: usize,
    /// The byte behind the last one; `start` where something is only inserted.
    pub end: usize,
    /// What stands there afterwards.
    pub text: String,
}

/// Edits that are made together or not at all, in one or several files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fix {
    /// The rule whose finding it removes, without prefix.
    pub rule: &'static str,
    /// What it does, in words.
    pub title: String,
    /// The file of the finding, as it is shown to users.
    pub file: String,
    /// The line of the finding, from 1.
    pub line: u32,
    /// Whether a person has to look at what it did.
    pub is_unsafe: bool,
    /// The edits. Those that are equal to one of another fix are made once.
    pub edits: Vec<Edit>,
}
