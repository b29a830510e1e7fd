//! Telling the client what was found: unasked, and when it asks.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::checking::is_rust;
use super::protocol::{Diagnostic, DocumentDiagnostic, WorkspaceDiagnostic};
use super::server::Server;
use crate::source::stable_hash;

/// What the client was told last.
#[derive(Debug, Default)]
pub(super) struct Published {
    /// Unasked, by file.
    sent: BTreeMap<PathBuf, Sent>,
    /// When it asked: the names of the results, by file.
    answered: BTreeMap<PathBuf, String>,
    /// Whether it has asked for everything at once.
    is_whole: bool,
    /// The hints may be others than they were.
    hints: String,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Sent {
    uri: String,
    version: Option<i64>,
    result: String,
    is_empty: bool,
}

impl Server {
    /// Sends what is new, and takes back what is no longer so. Of files that are neither open nor among those that changed, all
    /// is as it was.
    ///
    /// A client that asks for findings is told unasked of Rust files that it never had open, for some ask for no others; and of
    /// none as soon as it asks for all at once. What it has asked for it may go on showing.
    pub(super) fn publish(&mut self, changed: &BTreeSet<PathBuf>) {
        let (pulls, is_whole, answered) =
            (self.client.pulls_diagnostics, self.published.is_whole, &self.published.answered);
        let asks_for =
            |path: &Path, is_open: bool| pulls && is_rust(path) && (is_open || is_whole || answered.contains_key(path));
        let mut paths: BTreeSet<PathBuf> = changed.clone();
        paths.extend(self.documents.iter().map(|(path, _)| path.clone()));
        let was_open = self.published.sent.iter().filter(|(_, sent)| sent.version.is_some());
        paths.extend(was_open.map(|(path, _)| path.clone()));
        let told = self.published.sent.iter().filter(|(path, sent)| asks_for(path, false) && !sent.is_empty);
        paths.extend(told.map(|(path, _)| path.clone()));
        let mut messages = Vec::new();
        for path in paths {
            let before = self.published.sent.get(&path);
            let document = self.documents.get(&path);
            let is_asked_for = asks_for(&path, document.is_some());
            let diagnostics = if is_asked_for { Vec::new() } else { self.units.diagnostics_of(&path) };
            let now = Sent {
                uri: self.documents.uri_of(&path),
                version: document.map(|document| document.version),
                result: result_of(&diagnostics),
                is_empty: diagnostics.is_empty(),
            };
            // A client knows a file by its address: what it was told under another one is taken back.
            if let Some(before) = before.filter(|before| before.uri != now.uri && !before.is_empty) {
                messages.push(json!({ "uri": before.uri, "diagnostics": [] }));
            }
            let is_news = before.map_or(document.is_some() || !now.is_empty, |before| *before != now);
            // Nothing said of a file about which nothing is awaited, and nothing to say, is nothing new.
            let is_silent =
                (document.is_none() || is_asked_for) && now.is_empty && before.is_none_or(|before| before.is_empty);
            if is_news && !is_silent {
                let mut message = json!({ "uri": now.uri, "diagnostics": diagnostics });
                if let Some(version) = now.version {
                    message["version"] = version.into();
                }
                messages.push(message);
            }
            if document.is_some() || !now.is_empty {
                self.published.sent.insert(path, now);
            } else {
                self.published.sent.remove(&path);
            }
        }
        for message in messages {
            self.notify("textDocument/publishDiagnostics", &message);
        }
    }

    /// The findings of one file, or that they are the same as before.
    pub(super) fn document_report(&mut self, asked: &DocumentDiagnostic) -> Value {
        let path = self.documents.path_of(&asked.text_document.uri);
        let path = path.filter(|path| is_rust(path));
        let diagnostics = path.as_deref().map_or_else(Vec::new, |path| self.units.diagnostics_of(path));
        let result = result_of(&diagnostics);
        let report = report(&diagnostics, &result, asked.previous_result_id.as_deref());
        self.published.answered.extend(path.map(|path| (path, result)));
        report
    }

    /// The findings of all files, those included that had some before.
    pub(super) fn workspace_report(&mut self, asked: &WorkspaceDiagnostic) -> Value {
        let found = self.units.diagnostics();
        let mut answered = BTreeMap::new();
        let mut items = Vec::new();
        let mut add = |path: Option<&Path>, uri: String, previous: Option<&str>| {
            let diagnostics = path.and_then(|path| found.get(path)).map_or(&[][..], Vec::as_slice);
            let result = result_of(diagnostics);
            let mut item = report(diagnostics, &result, previous);
            item["version"] = path.and_then(|path| self.documents.get(path)).map(|document| document.version).into();
            item["uri"] = uri.into();
            items.push(item);
            answered.extend(path.map(|path| (path.to_owned(), result)));
        };
        let mut told = BTreeSet::new();
        for previous in &asked.previous_result_ids {
            let path = self.documents.path_of(&previous.uri).filter(|path| is_rust(path));
            add(path.as_deref(), previous.uri.clone(), Some(&previous.value));
            told.extend(path);
        }
        for path in found.keys().filter(|path| is_rust(path) && !told.contains(**path)) {
            add(Some(path), self.documents.uri_of(path), None);
        }
        self.published.answered.extend(answered);
        self.asks_for_all();
        json!({ "items": items })
    }

    /// The client asks for the findings of all files: what it was told unasked is taken back.
    pub(super) fn asks_for_all(&mut self) {
        if !std::mem::replace(&mut self.published.is_whole, true) && self.is_settled() {
            self.publish(&BTreeSet::new());
        }
    }

    /// Asks the client to ask again, where an answer that it has would be another one now.
    pub(super) fn refresh(&mut self, changed: &BTreeSet<PathBuf>) {
        if self.client.pulls_diagnostics && self.client.refreshes_diagnostics {
            let mut outdated: Vec<(PathBuf, String)> = Vec::new();
            for path in changed {
                let found = self.units.diagnostics_of(path);
                let now = result_of(&found);
                let is_outdated = match self.published.answered.get(path) {
                    Some(result) => now != *result,
                    None => self.published.is_whole && is_rust(path) && !found.is_empty(),
                };
                if is_outdated {
                    outdated.push((path.clone(), now));
                }
            }
            if !outdated.is_empty() {
                // It is told once of each change, whether it asks again or not.
                self.published.answered.extend(outdated);
                self.ask("workspace/diagnostic/refresh", &Value::Null, None);
            }
        }
        if self.client.refreshes_hints {
            let hints = if self.settings.inlay_hints { self.hints_result() } else { String::new() };
            if hints != std::mem::replace(&mut self.published.hints, hints.clone()) {
                self.ask("workspace/inlayHint/refresh", &Value::Null, None);
            }
        }
    }

    /// What all hints are made of.
    fn hints_result(&self) -> String {
        let cycles = self.units.reports().flat_map(|report| report.cycles.iter().map(move |cycle| (report, cycle)));
        let cycles = cycles.map(|(report, cycle)| {
            let pairs: Vec<_> = cycle.filters.iter().map(|pair| (&pair.name, pair.verdict)).collect();
            format!("{}:{}{pairs:?}", report.sources.file(cycle.head.file).name, cycle.head.start)
        });
        name_of(&cycles.collect::<String>())
    }
}

/// The findings of a file as the client asks for them.
fn report(diagnostics: &[&Diagnostic], result: &str, previous: Option<&str>) -> Value {
    if previous == Some(result) {
        return json!({ "kind": "unchanged", "resultId": result });
    }
    json!({ "kind": "full", "resultId": result, "items": diagnostics })
}

/// The name of a result, equal for equal findings.
fn result_of(diagnostics: &[&Diagnostic]) -> String {
    name_of(&serde_json::to_string(diagnostics).unwrap_or_default())
}

fn name_of(text: &str) -> String {
    format!("{:016x}", stable_hash(text.as_bytes()))
}
