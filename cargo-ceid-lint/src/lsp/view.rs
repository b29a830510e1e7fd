//! What was found, as the client wants to see it: which checks read a file, and where places are in it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::check::{Judged, Scope};
use super::client::Client;
use super::documents::{Documents, identity};
use super::protocol::{Diagnostic, Location, Range};
use super::text::Lines;
use crate::pipeline::Report;
use crate::project::Project;
use crate::source::{FileId, Span};

/// What is known of a scope since its last check.
#[derive(Debug, Default)]
pub(super) struct Unit {
    /// What was loaded, if there is code and it could be.
    project: Option<Arc<Project>>,
    parts: Vec<Arc<Part>>,
    /// Whether it could not be checked, so that nothing is known of its files.
    pub(super) is_failed: bool,
}

/// What is known of packages that have nothing to do with others.
#[derive(Debug, Default)]
pub(super) struct Part {
    report: Arc<Report>,
    /// The files that were read.
    files: BTreeMap<PathBuf, FileId>,
    /// What the client is shown.
    diagnostics: BTreeMap<PathBuf, Vec<Diagnostic>>,
}

impl Part {
    pub(super) fn new(report: Arc<Report>, diagnostics: BTreeMap<PathBuf, Vec<Diagnostic>>) -> Self {
        let files = report.sources.files().map(|(id, file)| (identity(&file.path), id)).collect();
        Self { report, files, diagnostics }
    }
}

impl Unit {
    /// The unit of a check; `part` makes those that are not in the unit of the check before.
    pub(super) fn of_judged(judged: &Judged, before: Option<&Self>, part: impl Fn(&Arc<Report>) -> Part) -> Self {
        let known = before.iter().flat_map(|unit| &unit.parts);
        let known: BTreeMap<*const Report, &Arc<Part>> = known.map(|part| (Arc::as_ptr(&part.report), part)).collect();
        let part =
            |report| known.get(&Arc::as_ptr(report)).map_or_else(|| Arc::new(part(report)), |part| Arc::clone(part));
        let parts = judged.reports.iter().map(part).collect();
        Self { project: Some(Arc::clone(&judged.project)), parts, is_failed: false }
    }

    /// A check that failed, with what is to be said of it.
    pub(super) fn failed(diagnostics: BTreeMap<PathBuf, Vec<Diagnostic>>) -> Self {
        let part = Part { diagnostics, ..Part::default() };
        Self { parts: vec![Arc::new(part)], is_failed: true, ..Self::default() }
    }

    /// What was found in a file that was read, with the file's number there.
    fn of_file(&self, path: &Path) -> Option<(&Report, FileId)> {
        self.parts.iter().find_map(|part| Some((&*part.report, *part.files.get(path)?)))
    }

    /// Whether a file was read.
    pub(super) fn reads(&self, path: &Path) -> bool {
        self.of_file(path).is_some()
    }

    /// Whether findings in a file are told by this check: it was read, and its package is reported.
    pub(super) fn covers(&self, path: &Path) -> bool {
        let (Some(project), Some((report, id))) = (&self.project, self.of_file(path)) else { return false };
        let path = &report.sources.file(id).path;
        let is_in = |package: &crate::project::Package| {
            package.is_around(path) || package.targets.iter().any(|target| target.src_path == *path)
        };
        project.is_wanted(path) && project.packages.iter().filter(|package| package.is_reported).any(is_in)
    }

    /// The files of which something is said by parts that another unit does not have.
    fn said_beside<'a>(&'a self, other: Option<&'a Self>) -> impl Iterator<Item = &'a PathBuf> {
        let others: BTreeSet<*const Part> = other.iter().flat_map(|unit| &unit.parts).map(Arc::as_ptr).collect();
        let own = self.parts.iter().filter(move |part| !others.contains(&Arc::as_ptr(part)));
        own.flat_map(|part| part.diagnostics.keys())
    }
}

/// All that is known, by scope.
#[derive(Debug, Default)]
pub(super) struct Units {
    of: BTreeMap<Scope, Unit>,
    /// The files of which something else may be said than when it was asked last.
    changed: BTreeSet<PathBuf>,
}

impl Units {
    pub(super) fn get(&self, scope: &Scope) -> Option<&Unit> {
        self.of.get(scope)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (&Scope, &Unit)> {
        self.of.iter()
    }

    /// Everything that was found.
    pub(super) fn reports(&self) -> impl Iterator<Item = &Report> {
        self.of.values().flat_map(|unit| &unit.parts).map(|part| &*part.report)
    }

    pub(super) fn insert(&mut self, scope: Scope, unit: Unit) {
        self.changed.extend(unit.said_beside(self.of.get(&scope)).cloned());
        if let Some(before) = self.of.get(&scope) {
            self.changed.extend(before.said_beside(Some(&unit)).cloned());
        }
        self.of.insert(scope, unit);
    }

    pub(super) fn remove(&mut self, scope: &Scope) {
        self.changed.extend(self.of.remove(scope).iter().flat_map(|unit| unit.said_beside(None)).cloned());
    }

    /// The files of which something else may be said than when this was asked last.
    pub(super) fn take_changed(&mut self) -> BTreeSet<PathBuf> {
        std::mem::take(&mut self.changed)
    }

    /// The findings of each file; those that two checks tell alike are told once.
    pub(super) fn diagnostics(&self) -> BTreeMap<&Path, Vec<&Diagnostic>> {
        let mut all: BTreeMap<&Path, Vec<&Diagnostic>> = BTreeMap::new();
        let parts = self.of.values().flat_map(|unit| &unit.parts);
        for (path, diagnostics) in parts.flat_map(|part| &part.diagnostics) {
            add_new(all.entry(path).or_default(), diagnostics);
        }
        all
    }

    /// The findings of one file.
    pub(super) fn diagnostics_of(&self, path: &Path) -> Vec<&Diagnostic> {
        let parts = self.of.values().flat_map(|unit| &unit.parts);
        let mut list = Vec::new();
        for diagnostics in parts.filter_map(|part| part.diagnostics.get(path)) {
            add_new(&mut list, diagnostics);
        }
        list
    }

    /// The check that tells the findings of a file, with what was checked and the file's number in it.
    pub(super) fn of_file(&self, path: &Path) -> Option<(&Report, Option<&Project>, FileId)> {
        let covering = self.of.values().find(|unit| unit.covers(path));
        let unit = covering.or_else(|| self.of.values().find(|unit| unit.reads(path)))?;
        unit.of_file(path).map(|(report, file)| (report, unit.project.as_deref(), file))
    }
}

fn add_new<'a>(list: &mut Vec<&'a Diagnostic>, diagnostics: &'a [Diagnostic]) {
    for diagnostic in diagnostics {
        if !list.contains(&diagnostic) {
            list.push(diagnostic);
        }
    }
}

/// A file with what was found in it.
#[derive(Debug)]
pub(super) struct View<'a> {
    pub(super) report: &'a Report,
    /// What was checked, if that is known.
    pub(super) project: Option<&'a Project>,
    pub(super) file: FileId,
    /// The identity of the file.
    pub(super) path: PathBuf,
    pub(super) lines: Lines<'a>,
    pub(super) client: &'a Client,
    pub(super) documents: &'a Documents,
}

impl<'a> View<'a> {
    pub(super) fn new(report: &'a Report, file: FileId, client: &'a Client, documents: &'a Documents) -> Self {
        let source = report.sources.file(file);
        let lines = Lines::new(&source.text);
        Self { report, project: None, file, path: identity(&source.path), lines, client, documents }
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
        if file == self.file {
            return self.documents.uri_of(&self.path);
        }
        self.documents.uri_of(&identity(&self.report.sources.file(file).path))
    }

    /// Whether a place of this file holds a byte, its end included: the cursor stands between two characters.
    pub(super) fn holds(&self, span: Span, offset: usize) -> bool {
        span.file == self.file && (span.start as usize..=span.end as usize).contains(&offset)
    }
}
