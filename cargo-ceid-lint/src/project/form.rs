//! What rustfmt makes of a text. Writes no file.

use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use super::Project;

impl Project {
    /// The text of a file as rustfmt has it there; `None` where it cannot say.
    #[must_use]
    pub fn formatted(&self, path: &Path, text: &str) -> Option<String> {
        let directory = path.parent()?;
        let program = std::env::var_os("RUSTFMT").filter(|program| !program.is_empty());
        let mut child = Command::new(program.unwrap_or_else(|| "rustfmt".into()))
            .args(["--quiet", "--emit", "stdout", "--edition", self.edition_at(path)])
            .current_dir(directory)
            .env("RUSTUP_AUTO_INSTALL", "0")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let mut input = child.stdin.take()?;
        // Rustfmt reads all before it writes, so that neither waits for the other.
        let fed = input.write_all(text.as_bytes());
        drop(input);
        let output = child.wait_with_output().ok()?;
        (fed.is_ok() && output.status.success()).then(|| String::from_utf8(output.stdout).ok())?
    }

    /// The edition of the target whose directory is nearest around a file.
    fn edition_at(&self, path: &Path) -> &str {
        let targets = self.packages.iter().flat_map(|package| &package.targets);
        let around = targets.filter_map(|target| {
            let directory = target.src_path.parent()?;
            let real = directory.canonicalize();
            let is_around = path.starts_with(directory) || real.is_ok_and(|real| path.starts_with(real));
            is_around.then(|| (directory.components().count(), &target.edition))
        });
        around.max_by_key(|(depth, _)| *depth).map_or("2021", |(_, edition)| edition)
    }
}
