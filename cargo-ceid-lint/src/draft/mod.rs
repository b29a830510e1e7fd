//! The text of a first `ceid-lint.toml`: every candidate with its reasons, behind `#` unless it is turned on.
//!
//! Prose begins with `# `; what can be turned on begins with `#` and no space, so that removing that `#` is all there is to do.

mod entries;
mod places;
mod prose;

use std::fmt::Write as _;
use std::path::Path;

use crate::candidates::{Candidates, Certainty, CycleCandidate, FilterCandidate};
use crate::config::spelling::nearest;
use crate::source::SourceMap;

use places::Places;

/// Which candidates are turned on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Accept {
    /// Those that are certain.
    Certain,
    /// All of them, but for filters that no code was seen to call.
    All,
    /// Those that are certain, and these, by name or path.
    Named(Vec<String>),
}

impl Accept {
    fn filter(&self, filter: &FilterCandidate) -> bool {
        // What nothing calls would only be owed updates.
        let is_called = filter.uses.calls + filter.uses.by_trait > 0;
        filter.certainty == Certainty::Certain || (self.names(&filter.path) && (is_called || *self != Self::All))
    }

    fn cycle(&self, cycle: &CycleCandidate) -> bool {
        self.names(cycle.target.path())
    }

    fn names(&self, path: &str) -> bool {
        match self {
            Self::Certain => false,
            Self::All => true,
            Self::Named(names) => names.iter().any(|name| is_named(path, name)),
        }
    }

    /// The first name that is no candidate's, with the nearest right one.
    #[must_use]
    pub fn unknown<'a>(&'a self, found: &'a [&Candidates]) -> Option<(&'a str, Option<&'a str>)> {
        let Self::Named(names) = self else { return None };
        let of_filters = found.iter().flat_map(|found| &found.filters).map(|filter| filter.path.as_str());
        let of_cycles = found.iter().flat_map(|found| &found.cycles).map(|cycle| cycle.target.path());
        let paths: Vec<&str> = of_filters.chain(of_cycles).collect();
        let unknown = names.iter().find(|name| !paths.iter().any(|path| is_named(path, name)))?;
        let lasts = paths.iter().map(|path| path.rsplit("::").next().unwrap_or(path));
        Some((unknown, nearest(unknown, lasts)))
    }
}

/// Whether a name is the end of a path: `Pid`, `control::Pid` and `crate::control::Pid` name the same.
fn is_named(path: &str, name: &str) -> bool {
    path.strip_suffix(name).is_some_and(|before| before.is_empty() || before.ends_with("::"))
}

/// A file, and how many of its entries are turned on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Draft {
    /// The text.
    pub text: String,
    /// The filters that are turned on.
    pub filters_on: usize,
    /// All filters in it.
    pub filters: usize,
    /// The cycles that are turned on.
    pub cycles_on: usize,
    /// All cycles in it.
    pub cycles: usize,
}

/// Writes the file that stands in `root`, whose packages a run with these flags checks.
#[must_use]
pub fn write(
    candidates: &Candidates,
    presets: &[&str],
    sources: &SourceMap,
    root: &Path,
    accept: &Accept,
    flags: &str,
) -> Draft {
    let places = &Places { sources, root };
    let filters_on = candidates.filters.iter().filter(|filter| accept.filter(filter)).count();
    let cycles_on = candidates.cycles.iter().filter(|cycle| accept.cycle(cycle)).count();
    let mut draft = Draft {
        text: prose::head(candidates, filters_on, cycles_on, flags),
        filters_on,
        filters: candidates.filters.len(),
        cycles_on,
        cycles: candidates.cycles.len(),
    };
    let text = &mut draft.text;
    prose::known(text, candidates, presets);
    // What is turned on needs no search in a long list.
    let (on, off): (Vec<_>, Vec<_>) = candidates.filters.iter().partition(|filter| accept.filter(filter));
    let of = |certainty: Certainty| move |filter: &&&FilterCandidate| filter.certainty == certainty;
    let likely: Vec<_> = off.iter().filter(|filter| filter.certainty != Certainty::Possible).collect();
    let possible: Vec<_> = off.iter().filter(of(Certainty::Possible)).collect();
    if !on.is_empty() {
        prose::heading(text, "Filters that are checked");
        on.iter().for_each(|filter| entries::filter(text, filter, places, true));
    }
    if !likely.is_empty() {
        prose::heading(text, "Most likely filters: remove the `#` of those that are");
        likely.iter().for_each(|filter| entries::filter(text, filter, places, false));
    }
    if !possible.is_empty() {
        prose::heading(text, "Perhaps filters");
        possible.iter().for_each(|filter| entries::filter(text, filter, places, false));
    }
    if !candidates.cycles.is_empty() {
        prose::heading(text, "Functions that look like control cycles; loops are found without an entry");
        candidates.cycles.iter().for_each(|cycle| entries::cycle(text, cycle, places, accept.cycle(cycle)));
    }
    prose::nameless(text, &candidates.nameless, places);
    if candidates.filters.is_empty() && candidates.cycles.is_empty() {
        prose::heading(text, "How an entry looks");
        let _ = write!(text, "{}", prose::EXAMPLE);
    }
    draft
}
