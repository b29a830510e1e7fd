//! Leaves out what has nothing to do with the lines that were changed.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use super::Report;
use crate::count::Cycle;
use crate::diagnostic::Diagnostic;
use crate::index::FunctionPlace;
use crate::project::{Changes, Removal};
use crate::source::{FileId, Span};

/// Methods that run where no name of theirs stands.
const IMPLICIT: [&str; 12] =
    ["drop", "deref", "deref_mut", "index", "index_mut", "next", "from", "add", "sub", "mul", "add_assign", "fmt"];

/// What was left out of a report because it touches no changed line.
#[derive(Clone, Debug, Default)]
pub struct Unchanged {
    /// The revision since which lines count as changed.
    pub revision: String,
    /// The findings that would be shown.
    pub findings: Vec<Diagnostic>,
    /// How many cycles.
    pub cycles: usize,
}

impl Report {
    /// Keeps the findings that touch what was changed since the revision.
    pub fn keep_changed(&mut self, revision: &str, changes: &Changes) {
        let touched = Touched::new(self, changes);
        let (kept, others): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.diagnostics).into_iter().partition(|finding| touched.has(self, finding));
        self.diagnostics = kept;
        let findings = others.into_iter().filter(Diagnostic::is_shown).collect();
        self.unchanged = Some(Unchanged { revision: revision.to_owned(), findings, cycles: 0 });
    }

    /// Keeps the cycles of functions that were changed since, and those whose updates or paths lie on changed lines.
    pub fn keep_changed_cycles(&mut self, changes: &Changes) {
        let touched = Touched::new(self, changes);
        let cycles = std::mem::take(&mut self.cycles);
        let all = cycles.len();
        self.cycles = cycles.into_iter().filter(|cycle| touched.has_cycle(self, cycle)).collect();
        if let Some(unchanged) = &mut self.unchanged {
            unchanged.cycles = all - self.cycles.len();
        }
    }
}

/// What was changed, by the files of a report.
struct Touched<'a> {
    changes: &'a Changes,
    /// The paths that the system has for the files.
    paths: BTreeMap<FileId, PathBuf>,
}

impl<'a> Touched<'a> {
    fn new(report: &Report, changes: &'a Changes) -> Self {
        let path = |path: &PathBuf| std::fs::canonicalize(path).unwrap_or_else(|_| path.clone());
        Self { changes, paths: report.sources.files().map(|(id, file)| (id, path(&file.path))).collect() }
    }

    /// Whether the place of a finding or a step of its path was changed, or what it does not find was taken away.
    fn has(&self, report: &Report, finding: &Diagnostic) -> bool {
        let steps = finding.witness.steps.iter().map(|step| step.span);
        let mut places = [finding.primary.span].into_iter().chain(finding.facts.cycle).chain(steps);
        // An update that is gone has no line left that could be changed.
        let is_absence = finding.facts.counts.contains(&0);
        places.any(|span| self.is_changed(report, span))
            || (is_absence && self.changes.removals.iter().any(|removal| self.may_miss(report, finding, removal)))
    }

    fn may_miss(&self, report: &Report, finding: &Diagnostic, removal: &Removal) -> bool {
        let is_named = |filter: &String| last_name(filter).is_some_and(|name| removal.names.contains(name));
        let place = finding.facts.cycle.unwrap_or(finding.primary.span);
        if finding.facts.filters.iter().any(is_named) && self.may_run(report, place, removal) {
            return true;
        }
        let Some(function) = report.functions.around(place) else { return false };
        let (_, end) = lines(report, function.span);
        let is_here = removal.file.as_ref() == self.paths.get(&place.file);
        is_here && (report.sources.line(place)..=end).contains(&removal.line)
    }

    /// Whether the function that something was taken from may run in a cycle: the names in the cycle's function lead to it, and those
    /// in the functions that these name. Where no function is known, it may.
    fn may_run(&self, report: &Report, cycle: Span, removal: &Removal) -> bool {
        let of_removal = removal.file.as_ref().and_then(|path| {
            let (file, _) = self.paths.iter().find(|(_, own)| *own == path)?;
            let holds = |function: &&FunctionPlace| {
                let (first, last) = lines(report, function.span);
                (first..last).contains(&removal.line)
            };
            report.functions.of_file(*file).iter().rfind(holds)
        });
        let (Some(wanted), Some(own)) = (of_removal, report.functions.around(cycle)) else { return true };
        let mut left: Vec<&FunctionPlace> = report.functions.iter().collect();
        let mut reached: Vec<&FunctionPlace> = vec![own];
        // What runs without being named may run.
        let mut names: BTreeSet<&str> = IMPLICIT.into_iter().collect();
        while !reached.is_empty() {
            if reached.contains(&wanted) {
                return true;
            }
            let words = reached.iter().flat_map(|function| {
                let text = report.sources.snippet(function.span);
                text.split(|letter: char| !letter.is_alphanumeric() && letter != '_')
            });
            names.extend(words);
            let is_named = |it: &&FunctionPlace| names.contains(it.path.rsplit("::").next().unwrap_or_default());
            (reached, left) = left.into_iter().partition(is_named);
        }
        false
    }

    fn has_cycle(&self, report: &Report, cycle: &Cycle) -> bool {
        let function = report.functions.around(cycle.head).map_or(cycle.head, |function| function.span);
        let (first, last) = lines(report, function);
        let path = self.paths.get(&function.file);
        let is_removal_here = |it: &Removal| it.file.as_ref() == path && (first..=last).contains(&it.line);
        let of_pairs = cycle.filters.iter().flat_map(|pair| {
            let steps = pair.witness.iter().map(|step| step.span);
            pair.updates.iter().copied().chain(pair.primary).chain(steps)
        });
        self.is_changed(report, function)
            || self.changes.removals.iter().any(is_removal_here)
            || of_pairs.into_iter().any(|span| self.is_changed(report, span))
    }

    fn is_changed(&self, report: &Report, span: Span) -> bool {
        let (first, last) = lines(report, span);
        self.paths.get(&span.file).is_some_and(|path| self.changes.touch(path, first, last))
    }
}

/// The first and the last line of a place.
fn lines(report: &Report, span: Span) -> (u32, u32) {
    let end = Span::new(span.file, span.end.saturating_sub(1).max(span.start), span.end);
    (report.sources.line(span), report.sources.line(end))
}

/// The last name in the place of a filter: `roll` of `self.axes.roll`, `pids` of `pids[0]`.
fn last_name(filter: &str) -> Option<&str> {
    let mut names = filter.split(|letter: char| !letter.is_alphanumeric() && letter != '_');
    names.rfind(|name| name.starts_with(|first: char| first.is_alphabetic() || first == '_'))
}
