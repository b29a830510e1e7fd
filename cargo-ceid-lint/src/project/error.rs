//! Why a project could not be loaded, in words for the user.

use std::fmt;
use std::path::Path;

use crate::diagnostic::Problem;

/// Why a project could not be loaded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadError {
    /// What happened, with the place; may have several lines when it is cargo's own text.
    pub message: String,
    /// What to do next.
    pub help: Option<String>,
}

impl LoadError {
    pub(super) fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), help: None }
    }

    pub(super) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The same as a problem of a report.
    #[must_use]
    pub fn problem(self, file: &Path) -> Problem {
        let file = file.to_string_lossy().into_owned();
        Problem { file, span: None, message: self.message, help: self.help, is_error: true }
    }

    /// Adds "did you mean", as cargo says it.
    pub(super) fn similar(self, what: &str, name: Option<&str>) -> Self {
        match name {
            Some(name) => self.help(format!("a {what} with a similar name exists: `{name}`")),
            None => self,
        }
    }
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for LoadError {}
