//! The formats: one file each, from a [`Report`] to text. Never prints, and never decides anything.

mod asides;
mod files;
mod fingerprint;
pub mod github;
mod gitlab;
pub mod html;
pub mod json;
mod junit;
mod line_hash;
pub mod progress;
pub mod proof;
mod repository;
pub mod rule_table;
mod sarif;
pub mod short;
mod stats;
mod summary;
mod tables;
pub mod text;
mod timings;
mod unread;

#[cfg(test)]
mod sample;

pub use asides::{asides, stale};
pub use stats::stats;
pub use summary::Summary;
pub use timings::timings;
pub use unread::unread;

use crate::pipeline::Report;
use crate::project::Project;

/// A form for a service that shows findings: one document for the whole run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Service {
    /// SARIF 2.1.0, for code scanning.
    Sarif,
    /// Workflow commands of GitHub Actions.
    Github,
    /// GitLab's code quality report.
    Gitlab,
    /// JUnit's XML.
    Junit,
}

/// How the run came out, for the forms that tell it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// The exit code.
    pub exit_code: u8,
    /// The part of the workspace that was checked, if not the whole: `slice-1-of-3`.
    pub part: Option<String>,
}

/// The run in the form of a service.
#[must_use]
pub fn document(service: Service, project: &Project, report: &Report, outcome: &Outcome) -> String {
    match service {
        Service::Sarif => sarif::document(project, report, outcome),
        Service::Github => github::annotations(project, report),
        Service::Gitlab => gitlab::document(project, report),
        Service::Junit => junit::document(project, report),
    }
}

/// How a text for people looks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Style {
    /// With ANSI colours.
    pub color: bool,
    /// With links from the names of files to the files.
    pub hyperlinks: bool,
    /// With all steps of a witness, however many there are.
    pub full_trace: bool,
}

/// An ANSI colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Paint {
    /// Right.
    Green,
    /// Wrong.
    Red,
    /// Neither.
    Yellow,
    /// A heading.
    Bold,
    /// A remark.
    Cyan,
}

impl Style {
    /// The text in a colour, if colours are on.
    #[must_use]
    pub fn paint(self, paint: Paint, text: &str) -> String {
        let code = match paint {
            Paint::Green => "1;32",
            Paint::Red => "1;31",
            Paint::Yellow => "1;33",
            Paint::Bold => "1",
            Paint::Cyan => "1;36",
        };
        if self.color { format!("\x1b[{code}m{text}\x1b[0m") } else { text.to_owned() }
    }
}

/// A text without line breaks.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The text with its first letter as a capital.
fn capitalized(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or(String::new(), |first| first.to_uppercase().collect::<String>() + characters.as_str())
}

/// `1 file`, `2 files`
#[must_use]
pub fn count(number: usize, noun: &str) -> String {
    format!("{number} {noun}{}", if number == 1 { "" } else { "s" })
}
