//! From a project to a report: the one function to read first.

use crate::config::Config;
use crate::count::Cycle;
use crate::diagnostic::{Diagnostic, Problem};
use crate::project::Project;
use crate::source::SourceMap;

/// What a run found out.
#[derive(Debug, Default)]
pub struct Report {
    /// Every text that was read.
    pub sources: SourceMap,
    /// The findings at `warn` or above, sorted by file, place and rule.
    pub diagnostics: Vec<Diagnostic>,
    /// Every cycle with its filters and their verdicts, sorted by file and place.
    pub cycles: Vec<Cycle>,
    /// What could not be read or parsed.
    pub problems: Vec<Problem>,
    /// How many filter types were found.
    pub filter_types: usize,
}

/// Checks a project. (Being built.)
#[must_use]
pub fn check(project: &Project, _config: &Config) -> Report {
    Report { sources: SourceMap::new(project.root.clone()), ..Report::default() }
}
