//! Findings as text that a test suite can keep: no colours, no figures of time, no paths of the machine.

use std::fmt;
use std::path::Path;

use crate::config::Config;
use crate::pipeline::{Gate, Options, Report, check_configured, check_with};
use crate::project::{self, Selection};
use crate::report::text;
use crate::source::{DiskSource, MemorySource};

/// What is checked.
#[derive(Clone, Copy, Debug)]
pub enum Subject<'a> {
    /// The package or workspace whose `Cargo.toml` lies in this directory, with its configuration.
    Directory(&'a Path),
    /// The text of one file that belongs to no package, shown as `source.rs`.
    Source(&'a str),
}

/// Why nothing could be checked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SnapshotError(String);

impl fmt::Display for SnapshotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for SnapshotError {}

/// Checks a crate or a source string, and answers what `cargo ceid-lint` prints of it: every finding with its path through the
/// source, what could not be read, and the summary.
///
/// The text is the same on every machine and whenever the code is: files are named from the directory of the workspace, and
/// those outside of it by `[outside]` and their own name. Meant for `insta::assert_snapshot!`.
///
/// # Errors
/// If there is no manifest, or cargo cannot read it. A wrong `ceid-lint.toml` is part of the text.
///
/// # Examples
/// ```
/// use cargo_ceid_lint::{Subject, snapshot};
///
/// let text = snapshot(Subject::Source(
///     "trait SampledFilter { fn update(&mut self); }
///      struct Heading(f64);
///      impl SampledFilter for Heading { fn update(&mut self) { self.0 *= 0.9; } }
///      fn steer(mut heading: Heading) {
///          loop {
///              heading.update();
///              heading.update();
///          }
///      }",
/// ))?;
/// assert!(text.starts_with("error[ceid::repeated_update]: `heading` is updated more than once in one cycle"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn snapshot(subject: Subject<'_>) -> Result<String, SnapshotError> {
    let report = match subject {
        Subject::Directory(directory) => {
            let current_dir = directory.canonicalize().unwrap_or_else(|_| directory.to_owned());
            let manifest_path = Some(current_dir.join("Cargo.toml"));
            let selection = Selection { current_dir, manifest_path, workspace: true, ..Selection::default() };
            let project = project::load(&selection).map_err(|error| SnapshotError(error.message))?;
            check_configured(&project, &Options::default(), Box::new(DiskSource)).report
        }
        Subject::Source(text) => {
            let path = Path::new("/source.rs");
            let mut source = MemorySource::default();
            source.insert(path, text.into());
            let project = project::of_file(path, text).map_err(|error| SnapshotError(error.message))?;
            let checked = check_with(&project, &Config::default(), Box::new(source), Gate::On);
            checked.map_err(|error| SnapshotError(error.message))?
        }
    };
    Ok(shown(&report))
}

fn shown(report: &Report) -> String {
    let mut shown = text::report(report);
    for (_, file) in report.sources.files().filter(|(_, file)| Path::new(&file.name).is_absolute()) {
        let name = file.path.file_name().unwrap_or_default().to_string_lossy();
        shown = shown.replace(&file.name, &format!("[outside]/{name}"));
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_configuration_and_a_missing_manifest_are_told() {
        let error = snapshot(Subject::Directory(Path::new("/there/is/none"))).unwrap_err();
        assert!(error.to_string().contains("/there/is/none"), "{error}");
    }

    #[test]
    fn a_source_string_needs_no_disk() {
        assert_eq!(snapshot(Subject::Source("fn main() {}")), Ok("checked 0 cycles with 0 filters\n".to_owned()));
        let broken = snapshot(Subject::Source("fn main( {}")).unwrap();
        assert!(broken.contains("source.rs:1:") && broken.ends_with("1 file could not be read\n"), "{broken}");
    }
}
