//! The long text of a rule, brought before the user's eyes in whatever way the client has.

use std::fs;
use std::path::{Path, PathBuf};
use std::process;

/// The command that shows the text of a rule, whose name is its only argument.
pub(super) const COMMAND: &str = "ceid-lint.explain";

/// A directory of this process for texts that the client is asked to open; gone when the server ends.
#[derive(Debug, Default)]
pub(super) struct Pages {
    directory: Option<PathBuf>,
}

impl Pages {
    /// Writes a text to a file of that name. None if that cannot be done; then it is shown as a message.
    pub(super) fn write(&mut self, name: &str, text: &str) -> Option<PathBuf> {
        if self.directory.is_none() {
            let directory = std::env::temp_dir().join(format!("cargo-ceid-lint-{}", process::id()));
            // One that is there already is somebody else's.
            fs::create_dir(&directory).ok()?;
            self.directory = Some(directory);
        }
        let path = self.directory.as_deref().unwrap_or(Path::new("")).join(format!("{name}.md"));
        fs::write(&path, text).ok()?;
        Some(path)
    }
}

impl Drop for Pages {
    fn drop(&mut self) {
        if let Some(directory) = &self.directory {
            let _ = fs::remove_dir_all(directory);
        }
    }
}
