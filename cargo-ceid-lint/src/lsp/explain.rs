//! The long text of a rule, brought before the user's eyes in whatever way the client has.

use std::fs;
use std::path::PathBuf;

/// The command that shows the text of a rule, whose name is its only argument.
pub(super) const COMMAND: &str = "ceid-lint.explain";

/// How many servers can have texts open at once.
const MOST_SERVERS: usize = 64;

/// A directory of this server for texts that the client is asked to open; gone when the server ends.
#[derive(Debug, Default)]
pub(super) struct Pages {
    directory: Option<PathBuf>,
}

impl Pages {
    /// Writes a text to a file of that name. None if that cannot be done; then it is shown as a message.
    pub(super) fn write(&mut self, name: &str, text: &str) -> Option<PathBuf> {
        if self.directory.is_none() {
            // A directory that is there already is somebody else's.
            let names = (0..MOST_SERVERS).map(|number| format!("cargo-ceid-lint-{number}"));
            let directories = names.map(|name| std::env::temp_dir().join(name));
            self.directory = directories.into_iter().find(|directory| fs::create_dir(directory).is_ok());
        }
        let path = self.directory.as_ref()?.join(format!("{name}.md"));
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
