//! What is wrong in the configuration, with its place and the nearest right spelling.

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::source::LineIndex;

/// A place in a configuration file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub path: PathBuf,
    /// 1-based line.
    pub line: u32,
    /// 1-based column in characters.
    pub column: u32,
    /// The bytes it spans.
    pub range: Range<usize>,
}

impl Place {
    pub(super) fn new(path: &Path, text: &str, range: Range<usize>) -> Self {
        let at = LineIndex::default().line_column(text, u32::try_from(range.start).unwrap_or(u32::MAX));
        Self { path: path.to_owned(), line: at.line, column: at.column, range }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.path.display(), self.line, self.column)
    }
}

/// What is wrong in the configuration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConfigError {
    /// Where; `None` for a file that cannot be read, which the message names.
    pub place: Option<Place>,
    /// What is wrong.
    pub message: String,
    /// What to do next.
    pub help: Option<String>,
    /// The whole text, so that the place can be shown.
    pub text: Option<Arc<str>>,
    /// What else is wrong.
    pub next: Option<Box<ConfigError>>,
}

impl ConfigError {
    /// An error at `place`.
    #[must_use]
    pub fn at(place: Place, message: impl Into<String>) -> Self {
        Self { place: Some(place), ..Self::without_place(message) }
    }

    /// An error whose message says where it is.
    #[must_use]
    pub fn without_place(message: impl Into<String>) -> Self {
        Self { place: None, message: message.into(), help: None, text: None, next: None }
    }

    /// The same, saying what to do next.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// All of these as one; `None` if there are none.
    #[must_use]
    pub fn all(errors: Vec<Self>) -> Option<Self> {
        errors.into_iter().rev().reduce(|rest, mut error| {
            let mut last = &mut error.next;
            while let Some(next) = last {
                last = &mut next.next;
            }
            *last = Some(Box::new(rest));
            error
        })
    }

    /// This error and what else is wrong.
    pub fn each(&self) -> impl Iterator<Item = &Self> {
        std::iter::successors(Some(self), |error| error.next.as_deref())
    }

    /// The same, shown in a text.
    #[must_use]
    pub fn in_text(mut self, text: &Arc<str>) -> Self {
        self.text.get_or_insert_with(|| Arc::clone(text));
        self.next = self.next.map(|next| Box::new(next.in_text(text)));
        self
    }

    /// The same, with "did you mean" or the list of what there is.
    #[must_use]
    pub fn did_you_mean(self, word: &str, known: &[&str]) -> Self {
        match super::spelling::nearest(word, known.iter().copied()) {
            Some(name) => self.help(format!("did you mean `{name}`?")),
            None => self.help(format!("known are {}", list(known))),
        }
    }
}

fn list(names: &[&str]) -> String {
    let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    names.join(", ")
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.place {
            Some(place) => write!(f, "`{place}`: {}", self.message),
            None => f.write_str(&self.message),
        }
    }
}

impl std::error::Error for ConfigError {}
