//! What was found, as the client wants to see it: which checks read a file, and where places are in it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::check::{Judged, Scope};
use super::client::Client;
use super::documents::{Documents, identity};
use super::protocol::{Diagnostic, Location, Range};
use super::text::Lines;
use crate::pipeline::Report;
use crate::source::{FileId, Span};

/// What is known of a scope since its last check.
#[derive(Debug, Default)]
pub(super) struct Unit {
    /// What was found; nothing if there is no code, or if it could not be loaded.
    pub(super) judged: Option<Box<Judged>>,
    /// The files that were read.
    pub(super) files: BTreeMap<PathBuf, FileId>,
    /// What the client is shown.
    pub(super) diagnostics: BTreeMap<PathBuf, Vec<Diagnostic>>,
    /// Whether it could not be checked, so that nothing is known of its files.
    pub(super) is_failed: bool,
}

impl Unit {
    pub(super) fn of_judged(judged: Box<Judged>, diagnostics: BTreeMap<PathBuf, Vec<Diagnostic>>) -> Self {
        let files = judged.report.sources.files().map(|(id, file)| (identity(&file.path), id)).collect();
        Self { judged: Some(judged), files, diagnostics, is_failed: false }
    }

    /// Whether findings in a file are told by this check: it was read, and its package is reported.
    pub(super) fn covers(&self, path: &Path) -> bool {
        let (Some(judged), Some(id)) = (&self.judged, self.files.get(path)) else { return false };
        let path = &judged.report.sources.file(*id).path;
        let is_in = |package: &crate::project::Package| {
            let directory = package.manifest_path.parent().filter(|directory| directory.is_absolute());
            directory.is_some_and(|directory| path.starts_with(directory))
                || package.targets.iter().any(|target| target.src_path == *path)
        };
        judged.project.is_wanted(path)
            && judged.project.packages.iter().filter(|package| package.is_reported).any(is_in)
    }
}

/// All that is known, by scope.
#[derive(Debug, Default)]
pub(super) struct Units(pub(super) BTreeMap<Scope, Unit>);

impl Units {
    /// The findings of each file; those that two checks tell alike are told once.
    pub(super) fn diagnostics(&self) -> BTreeMap<&Path, Vec<&Diagnostic>> {
        let mut all: BTreeMap<&Path, Vec<&Diagnostic>> = BTreeMap::new();
        for (path, diagnostics) in self.0.values().flat_map(|unit| &unit.diagnostics) {
            let list = all.entry(path).or_default();
            for diagnostic in diagnostics {
                if !list.contains(&diagnostic) {
                    list.push(diagnostic);
                }
            }
        }
        all
    }

    /// The findings of one file.
    pub(super) fn diagnostics_of(&self, path: &Path) -> Vec<&Diagnostic> {
        let mut list = Vec::new();
        for diagnostic in self.0.values().filter_map(|unit| unit.diagnostics.get(path)).flatten() {
            if !list.contains(&diagnostic) {
                list.push(diagnostic);
            }
        }
        list
    }

    /// The check that tells the findings of a file, with the file's number in it.
    pub(super) fn of_file(&self, path: &Path) -> Option<(&Judged, FileId)> {
        let covering = self.0.values().find(|unit| unit.covers(path));
        let unit = covering.or_else(|| self.0.values().find(|unit| unit.files.contains_key(path)))?;
        Some((unit.judged.as_deref()?, *unit.files.get(path)?))
    }
}

/// A file with what was found in it.
#[derive(Debug)]
pub(super) struct View<'a> {
    pub(super) report: &'a Report,
    pub(super) file: FileId,
    pub(super) lines: Lines<'a>,
    pub(super) client: &'a Client,
    pub(super) documents: &'a Documents,
}

impl<'a> View<'a> {
    pub(super) fn new(report: &'a Report, file: FileId, client: &'a Client, documents: &'a Documents) -> Self {
        let lines = Lines::new(&report.sources.file(file).text);
        Self { report, file, lines, client, documents }
    }

    /// The findings that an editor shows: those that are known as well.
    pub(super) fn findings(&self) -> impl Iterator<Item = &'a crate::diagnostic::Diagnostic> {
        self.report.diagnostics.iter().filter(|finding| finding.suppressed.is_none())
    }

    /// A place in this file.
    pub(super) fn range(&self, span: Span) -> Range {
        self.lines.range_of(span, self.client.encoding)
    }

    /// A place in any file of the report.
    pub(super) fn location(&self, span: Span) -> Location {
        if span.file == self.file {
            return Location { uri: self.uri(span.file), range: self.range(span) };
        }
        let lines = Lines::new(&self.report.sources.file(span.file).text);
        Location { uri: self.uri(span.file), range: lines.range_of(span, self.client.encoding) }
    }

    /// The address of a file of the report.
    pub(super) fn uri(&self, file: FileId) -> String {
        self.documents.uri_of(&identity(&self.report.sources.file(file).path))
    }

    /// Whether a place of this file holds a byte, its end included: the cursor stands between two characters.
    pub(super) fn holds(&self, span: Span, offset: usize) -> bool {
        span.file == self.file && (span.start as usize..=span.end as usize).contains(&offset)
    }
}
