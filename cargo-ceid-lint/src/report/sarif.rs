//! SARIF 2.1.0 (OASIS), as code scanning services read it. The section numbers are those of the standard.

use rustc_hash::FxHashMap;

use serde_json::{Value, json};

use super::fingerprint::fingerprints;
use super::line_hash::line_hashes;
use super::repository::{LineRange, Repository, first_line};
use super::{Outcome, capitalized};
use crate::baseline::Comparison;
use crate::diagnostic::{Diagnostic, Level, Problem, Severity, WitnessStep};
use crate::pipeline::Report;
use crate::project::Project;
use crate::rules::{Group, RULES, Rule};
use crate::source::{FileId, SourceMap, Span};

/// What the root of the repository is called, for readers that resolve paths (§3.14.14).
const ROOT: &str = "%SRCROOT%";

/// The whole document. Every finding is a result, suppressed ones included; what could not be read is a notification.
pub(super) fn document(project: &Project, report: &Report, outcome: &Outcome) -> String {
    let baseline = report.baselines.iter().find(|comparison| comparison.old.is_some()).map(Comparison::name);
    let scope = Scope { sources: &report.sources, repository: Repository::around(&project.root), baseline };
    let prints = fingerprints(&report.sources, &report.diagnostics);
    let mut hashes: FxHashMap<FileId, Vec<String>> = FxHashMap::default();
    let results = report.diagnostics.iter().zip(&prints).map(|(diagnostic, print)| {
        let span = diagnostic.primary.span;
        let of_file = hashes.entry(span.file).or_insert_with(|| line_hashes(&report.sources.file(span.file).text));
        let line = first_line(&report.sources, span).line as usize;
        let hash = of_file.get(line - 1).map_or("", String::as_str);
        scope.result(diagnostic, print, hash)
    });
    let results: Vec<Value> = results.collect();
    let part = outcome.part.as_deref().map_or(String::new(), |part| format!("{part}/"));
    let document = json!({
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [{
            "tool": { "driver": {
                "name": "cargo-ceid-lint",
                "version": env!("CARGO_PKG_VERSION"),
                "semanticVersion": env!("CARGO_PKG_VERSION"),
                "rules": RULES.iter().map(rule).collect::<Vec<_>>(),
            }},
            "automationDetails": { "id": format!("ceid-lint/{part}") },
            "columnKind": "unicodeCodePoints",
            "originalUriBaseIds": { ROOT: { "description": { "text": "The root of the repository." } } },
            "invocations": [{
                "executionSuccessful": report.problems.is_empty(),
                "exitCode": outcome.exit_code,
                "toolExecutionNotifications":
                    report.problems.iter().map(|problem| scope.notification(problem, project)).collect::<Vec<_>>(),
            }],
            "results": results,
        }],
    });
    format!("{document:#}\n")
}

/// A rule with its help (§3.49). Readers cut texts at 1,024 characters.
fn rule(rule: &Rule) -> Value {
    let severity = match rule.default_level.severity() {
        Some(Severity::Error) => "error",
        Some(Severity::Warning) => "warning",
        None => "recommendation",
    };
    let precision = match rule.group {
        Group::Correctness | Group::Hygiene => "very-high",
        Group::Suspicious | Group::TimeDomain => "high",
        Group::Proof => "medium",
    };
    json!({
        "id": rule.id(),
        "name": rule.name,
        "shortDescription": { "text": sentence(rule.summary) },
        "fullDescription": { "text": sentence(&format!("{}; {}", rule.summary, rule.group.summary())) },
        "help": { "text": rule.explanation, "markdown": rule.explanation },
        "defaultConfiguration": { "enabled": rule.default_level > Level::Allow, "level": level(rule.default_level) },
        "properties": {
            "tags": ["control-loop", rule.group.name()],
            "precision": precision,
            "problem.severity": severity,
        },
    })
}

fn level(level: Level) -> &'static str {
    level.severity().map_or("note", Severity::name)
}

/// A text as a sentence: messages are lower case without a full stop, which SARIF asks for (§3.11.2).
fn sentence(text: &str) -> String {
    capitalized(text) + "."
}

/// What places are shown in.
struct Scope<'a> {
    sources: &'a SourceMap,
    repository: Repository,
    /// The name of the baseline, if the findings were compared with one.
    baseline: Option<String>,
}

impl Scope<'_> {
    fn result(&self, diagnostic: &Diagnostic, print: &str, hash: &str) -> Value {
        let steps: Vec<Value> = (1..).zip(&diagnostic.witness.steps).map(|step| self.step(step)).collect();
        let mut location = self.location(diagnostic.primary.span, &diagnostic.primary.message);
        if !diagnostic.facts.function.is_empty() {
            location["logicalLocations"] =
                json!([{ "fullyQualifiedName": diagnostic.facts.function, "kind": "function" }]);
        }
        // An empty list says that a result is not suppressed; without one nobody can know (§3.27.23).
        let suppressions = diagnostic.suppressed.iter().map(|reason| match reason.as_str() {
            "" => json!({ "kind": "inSource" }),
            reason => json!({ "kind": "inSource", "justification": reason }),
        });
        // What is known stays in the file, with its level and its fingerprint: a service takes what is no longer there for fixed.
        let known = self.baseline.iter().filter(|_| diagnostic.known).map(
            |name| json!({ "kind": "external", "status": "accepted", "justification": format!("known: in {name}") }),
        );
        let mut result = json!({
            "ruleId": format!("ceid::{}", diagnostic.rule),
            "ruleIndex": RULES.iter().position(|rule| rule.name == diagnostic.rule),
            "level": level(diagnostic.level),
            "message": { "text": message(diagnostic) },
            "locations": [location],
            "partialFingerprints": { "primaryLocationLineHash": hash, "ceidFinding/v1": print },
            "suppressions": suppressions.chain(known).collect::<Vec<_>>(),
            "properties": {
                "verdict": diagnostic.facts.verdict,
                "counts": diagnostic.facts.counts,
                "filters": diagnostic.facts.filters,
                "type": diagnostic.facts.filter_type,
            },
        });
        // Either every result has a state, or none has (§3.27.24).
        if self.baseline.is_some() {
            result["baselineState"] = json!(if diagnostic.known { "unchanged" } else { "new" });
        }
        if !steps.is_empty() {
            result["codeFlows"] = json!([{ "threadFlows": [{ "locations": steps }] }]);
        }
        if !diagnostic.suggestions.is_empty() {
            let fixes = diagnostic.suggestions.iter().map(|suggestion| {
                let mut changes: Vec<(FileId, Vec<Value>)> = Vec::new();
                for (span, text) in &suggestion.edits {
                    let replacement = json!({
                        "deletedRegion": self.whole_region(*span),
                        "insertedContent": { "text": text },
                    });
                    match changes.iter_mut().find(|(file, _)| *file == span.file) {
                        Some((_, replacements)) => replacements.push(replacement),
                        None => changes.push((span.file, vec![replacement])),
                    }
                }
                let changes = changes.into_iter().map(|(file, replacements)| {
                    json!({ "artifactLocation": self.artifact(file), "replacements": replacements })
                });
                json!({
                    "description": { "text": sentence(&suggestion.message) },
                    "artifactChanges": changes.collect::<Vec<_>>(),
                })
            });
            result["fixes"] = fixes.collect();
        }
        result
    }

    /// A step of the path (§3.38).
    fn step(&self, (number, step): (u32, &WitnessStep)) -> Value {
        json!({
            "executionOrder": number,
            "importance": "essential",
            "location": self.location(step.span, &step.message),
        })
    }

    fn location(&self, span: Span, message: &str) -> Value {
        let LineRange { line, start, end } = first_line(self.sources, span);
        let mut location = json!({ "physicalLocation": {
            "artifactLocation": self.artifact(span.file),
            "region": { "startLine": line, "startColumn": start, "endLine": line, "endColumn": end },
        }});
        if !message.is_empty() {
            location["message"] = json!({ "text": message });
        }
        location
    }

    /// What a fix deletes, over all of its lines.
    fn whole_region(&self, span: Span) -> Value {
        let file = self.sources.file(span.file);
        let start = file.lines.line_column(&file.text, span.start);
        let end = file.lines.line_column(&file.text, span.end);
        json!({
            "startLine": start.line, "startColumn": start.column, "endLine": end.line, "endColumn": end.column,
        })
    }

    fn artifact(&self, file: FileId) -> Value {
        artifact_at(self.repository.uri(&self.sources.file(file).path))
    }

    /// Something that could not be read or parsed (§3.58).
    fn notification(&self, problem: &Problem, project: &Project) -> Value {
        let text = match &problem.help {
            Some(help) => format!("{}; {help}", problem.message),
            None => problem.message.clone(),
        };
        let location = match problem.span {
            Some(span) => self.location(span, ""),
            None => json!({ "physicalLocation": {
                "artifactLocation": artifact_at(self.repository.uri(&project.root.join(&problem.file))),
            }}),
        };
        let locations = if problem.file.is_empty() { json!([]) } else { json!([location]) };
        json!({ "level": "error", "message": { "text": sentence(&text) }, "locations": locations })
    }
}

/// A file; only what lies in the repository is relative to its root.
fn artifact_at(uri: String) -> Value {
    if uri.starts_with("file:") { json!({ "uri": uri }) } else { json!({ "uri": uri, "uriBaseId": ROOT }) }
}

/// The message, why it matters, and what to do: for a reader who sees nothing else.
fn message(diagnostic: &Diagnostic) -> String {
    let parts = [&diagnostic.message].into_iter().chain(&diagnostic.notes).chain(&diagnostic.helps);
    parts.map(|part| sentence(part)).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;

    fn run() -> Value {
        let (project, report) = sample::report();
        let outcome = Outcome { exit_code: 101, part: Some("slice-1-of-3".to_owned()) };
        let document: Value = serde_json::from_str(&document(&project, &report, &outcome)).unwrap();
        document["runs"][0].clone()
    }

    #[test]
    fn the_results_look_as_documented() {
        let mut run = run();
        run["tool"]["driver"]["rules"] = json!([]);
        run["tool"]["driver"]["version"] = json!("0.0.0");
        run["tool"]["driver"]["semanticVersion"] = json!("0.0.0");
        insta::assert_snapshot!(format!("{run:#}"));
    }

    #[test]
    fn every_finding_is_a_result_and_every_problem_a_notification() {
        let (_, report) = sample::report();
        let run = run();
        assert_eq!(run["results"].as_array().unwrap().len(), report.diagnostics.len());
        let notifications = run["invocations"][0]["toolExecutionNotifications"].as_array().unwrap();
        assert_eq!(notifications.len(), report.problems.len());
    }

    #[test]
    fn texts_of_rules_are_not_longer_than_readers_allow() {
        for rule in run()["tool"]["driver"]["rules"].as_array().unwrap() {
            for field in ["shortDescription", "fullDescription"] {
                let length = rule[field]["text"].as_str().unwrap().chars().count();
                assert!((1..=1024).contains(&length), "{field} of {}", rule["id"]);
            }
            assert!(!rule["help"]["text"].as_str().unwrap().is_empty());
        }
    }
}
