//! What was found beside what is known: which of it is new, and what is fixed.

use std::collections::BTreeSet;
use std::path::PathBuf;

use super::{Counts, Key};
use crate::diagnostic::{Diagnostic, Level};

/// A baseline, and what a run has found in its workspace.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Comparison {
    /// Where the baseline is, or would be.
    pub path: PathBuf,
    /// What it holds; `None` if there is no such file.
    pub old: Option<Counts>,
    /// What was found and may be known.
    pub found: Counts,
    /// Those of the old names that this run has looked for.
    pub checked: BTreeSet<Key>,
    /// How many findings are hidden.
    pub known: usize,
    /// How many findings cannot be known, because their rules are forbidden.
    pub forbidden: usize,
    /// What these are counted by: they are there, and neither known nor fixed.
    pub forbidden_keys: BTreeSet<Key>,
}

impl Comparison {
    /// A baseline that nothing was compared with yet.
    #[must_use]
    pub fn new(path: PathBuf, old: Option<Counts>) -> Self {
        Self { path, old, ..Self::default() }
    }

    /// The file's own name, for messages.
    #[must_use]
    pub fn name(&self) -> String {
        self.path.file_name().unwrap_or(self.path.as_os_str()).to_string_lossy().into_owned()
    }

    /// Counts what was found, and marks what is known. Where there is more than is known, all of it is shown: nothing tells
    /// which of it is new.
    pub fn mark(&mut self, mut findings: Vec<(&mut Diagnostic, Vec<Key>)>) {
        findings.retain(|(finding, _)| finding.suppressed.is_none());
        for (finding, keys) in &findings {
            // What is forbidden is hidden by nothing.
            if finding.level == Level::Forbid {
                self.forbidden += 1;
                self.forbidden_keys.extend(keys.iter().cloned());
                continue;
            }
            for key in keys {
                *self.found.entry(key.clone()).or_default() += 1;
            }
        }
        let Some(old) = &self.old else { return };
        for (finding, keys) in findings.into_iter().filter(|(finding, _)| finding.level != Level::Forbid) {
            let numbers = |key: &Key| (old.get(key).copied().unwrap_or(0), self.found.get(key).copied().unwrap_or(0));
            finding.known = keys.iter().all(|key| matches!(numbers(key), (known, found) if found <= known));
            // They are counted as the file counts them.
            self.known += if finding.known { keys.len() } else { 0 };
            let more = keys.iter().find(|key| matches!(numbers(key), (1.., found) if found > numbers(key).0));
            if let Some(key) = more {
                let (known, found) = numbers(key);
                let about = if key.filter.is_empty() { String::new() } else { format!(" on `{}`", key.filter) };
                finding.notes.push(format!(
                    "there are {found} such findings{about} in this function, and `{}` knows {known}: all are shown, as \
                     nothing tells which is new",
                    self.name()
                ));
            }
        }
    }

    /// How many findings of the baseline are fixed, as far as this run has looked.
    #[must_use]
    pub fn stale(&self) -> u32 {
        let old = self.old.iter().flatten().filter(|(key, _)| self.may_be_fixed(key));
        old.map(|(key, known)| known.saturating_sub(self.number_found(key))).sum()
    }

    /// How many findings the baseline does not hold.
    #[must_use]
    pub fn new_findings(&self) -> u32 {
        let known = |key: &Key| self.old.as_ref().and_then(|old| old.get(key)).copied().unwrap_or(0);
        self.found.iter().map(|(key, found)| found.saturating_sub(known(key))).sum()
    }

    /// What the baseline holds when new findings are accepted or fixed ones are taken out.
    #[must_use]
    pub fn updated(&self, accepts_new: bool, prunes: bool) -> Counts {
        let mut counts = self.old.clone().unwrap_or_default();
        if prunes {
            for key in self.checked.iter().filter(|key| self.may_be_fixed(key)) {
                if let Some(known) = counts.get_mut(key) {
                    *known = (*known).min(self.number_found(key));
                }
            }
            counts.retain(|_, known| *known > 0);
        }
        if accepts_new {
            for (key, found) in &self.found {
                let known = counts.entry(key.clone()).or_default();
                *known = (*known).max(*found);
            }
        }
        counts
    }

    /// Whether a finding of the baseline was looked for, and is not shown because its rule is forbidden.
    fn may_be_fixed(&self, key: &Key) -> bool {
        self.checked.contains(key) && !self.forbidden_keys.contains(key)
    }

    fn number_found(&self, key: &Key) -> u32 {
        self.found.get(key).copied().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(function: &str) -> Key {
        Key {
            file: "src/lib.rs".to_owned(),
            function: function.to_owned(),
            rule: "missed_update",
            filter: "kf".to_owned(),
        }
    }

    fn counts(list: &[(&str, u32)]) -> Counts {
        list.iter().map(|(function, number)| (key(function), *number)).collect()
    }

    fn comparison(old: &[(&str, u32)], found: &[(&str, u32)], checked: &[&str]) -> Comparison {
        let checked = checked.iter().map(|function| key(function)).collect();
        Comparison { old: Some(counts(old)), found: counts(found), checked, ..Comparison::default() }
    }

    #[test]
    fn what_was_not_looked_for_is_neither_fixed_nor_taken_out() {
        let it = comparison(&[("a", 2), ("b", 1)], &[("a", 1)], &["a"]);
        assert_eq!((it.stale(), it.new_findings()), (1, 0));
        assert_eq!(it.updated(false, true), counts(&[("a", 1), ("b", 1)]));
    }

    #[test]
    fn what_a_forbidden_rule_shows_is_not_fixed() {
        let it = comparison(&[("a", 2), ("b", 1)], &[], &["a", "b"]);
        let it = Comparison { forbidden: 2, forbidden_keys: [key("a")].into(), ..it };
        assert_eq!(it.stale(), 1);
        assert_eq!(it.updated(false, true), counts(&[("a", 2)]));
    }

    #[test]
    fn pruning_adds_nothing_and_accepting_takes_nothing_out() {
        let it = comparison(&[("a", 2), ("b", 1)], &[("a", 3), ("c", 1)], &["a", "b"]);
        assert_eq!((it.stale(), it.new_findings()), (1, 2));
        assert_eq!(it.updated(false, true), counts(&[("a", 2)]));
        assert_eq!(it.updated(true, false), counts(&[("a", 3), ("b", 1), ("c", 1)]));
        assert_eq!(it.updated(true, true), it.found);
        assert_eq!(it.updated(false, false), counts(&[("a", 2), ("b", 1)]));
    }
}
