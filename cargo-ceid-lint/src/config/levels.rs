//! Levels that somebody asked for, in the order in which they win. Knows no rules: names are checked where rules are known.

use super::Place;
use crate::diagnostic::Level;

/// The levels of the command line, in order: a later one wins.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LevelOverrides {
    entries: Vec<LevelOverride>,
}

impl LevelOverrides {
    /// Adds an override that wins over all that are there.
    pub fn push(&mut self, name: &str, level: Level, source: LevelSource) {
        self.entries.push(LevelOverride { name: without_prefix(name).to_owned(), level, priority: 0, source });
    }

    /// All overrides, the weakest first.
    #[must_use]
    pub fn entries(&self) -> &[LevelOverride] {
        &self.entries
    }
}

/// A level that somebody asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LevelOverride {
    /// A rule or a group without `ceid::`, or `warnings`.
    pub name: String,
    /// The level.
    pub level: Level,
    /// Within one `[lints]`, the higher one wins.
    pub priority: i64,
    /// Where it was asked for.
    pub source: LevelSource,
}

/// Where a level was asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LevelSource {
    /// On the command line, in these words: `-D ceid::proof`.
    CommandLine(String),
    /// In a configuration file.
    File(Place),
}

impl LevelSource {
    /// The end of a sentence: "on the command line".
    #[must_use]
    pub fn phrase(&self) -> String {
        match self {
            Self::CommandLine(_) => "on the command line".to_owned(),
            Self::File(place) => {
                let name = place.path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
                format!("in `{name}`")
            }
        }
    }
}

/// The name of a rule or group without the tool's prefix.
#[must_use]
pub(super) fn without_prefix(name: &str) -> &str {
    name.strip_prefix("ceid::").unwrap_or(name)
}
