//! What the client offers to do about a finding: its own suggestions, a suppression with a reason, and the text of its rule.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Value, json};

use super::documents::identity;
use super::explain;
use super::protocol::{InRange, Range, TextEdit};
use super::text::Lines;
use super::view::View;
use crate::count::{Cycle, Verdict};
use crate::diagnostic::{Applicability, Diagnostic, Level, Suggestion};
use crate::migrate::{Plan, Rewrite};
use crate::pipeline::dependencies;
use crate::report::text::suggested;
use crate::rules::{self, Group};
use crate::source::{FileId, Span};

const QUICK_FIX: &str = "quickfix";
const REWRITE: &str = "refactor.rewrite";

/// The actions for the lines of a range.
pub(super) fn actions(view: &View<'_>, asked: &InRange) -> Vec<Value> {
    let mut migrations = Vec::new();
    if wants(asked, REWRITE) && view.client.takes_actions {
        migrations.extend(view.report.plans.iter().flat_map(|plan| migrate(view, plan, asked.range)));
    }
    if !wants(asked, QUICK_FIX) {
        return migrations;
    }
    let findings: Vec<&Diagnostic> = view.findings().filter(|finding| is_on(view, finding, asked.range)).collect();
    let mut actions = Vec::new();
    if view.client.takes_actions {
        for finding in &findings {
            let about = about(view, finding, &asked.context.diagnostics);
            actions.extend(finding.suggestions.iter().map(|suggestion| fix(view, suggestion, &about)));
        }
        for finding in &findings {
            actions.extend(suppression(view, finding, &about(view, finding, &asked.context.diagnostics)));
        }
    }
    let rules: BTreeSet<&str> = findings.iter().map(|finding| finding.rule).collect();
    actions.extend(migrations);
    actions.extend(rules.into_iter().map(|rule| explanation(view, rule)));
    actions
}

/// Whether the client asks for actions of a kind.
fn wants(asked: &InRange, kind: &str) -> bool {
    let is_kind = |wanted: &str| {
        wanted.is_empty() || kind.strip_prefix(wanted).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    asked.context.only.as_ref().is_none_or(|kinds| kinds.iter().any(|wanted| is_kind(wanted)))
}

/// Whether there may be a loop in a range whose filters a guard could have.
pub(super) fn may_migrate(view: &View<'_>, asked: &InRange) -> bool {
    let is_by_hand = |cycle: &&Cycle| cycle.filters.iter().any(|pair| pair.verdict != Verdict::Guarded);
    let mut by_hand = view.report.cycles.iter().filter(is_by_hand);
    wants(asked, REWRITE) && view.client.takes_actions && by_hand.any(|cycle| begins_in(view, cycle.head, asked.range))
}

/// Whether the head of a loop is on the lines of a range of this file.
fn begins_in(view: &View<'_>, head: Span, range: Range) -> bool {
    head.file == view.file && {
        let own = view.range(head);
        own.start.line <= range.end.line && range.start.line <= own.end.line
    }
}

/// Hands the filters of a loop to a guard, or some of them, where its head is on the lines of a range; the packages depend on
/// `ceid-core` then.
fn migrate(view: &View<'_>, plan: &Plan, range: Range) -> Vec<Value> {
    if !begins_in(view, plan.head, range) {
        return Vec::new();
    }
    let action = |(title, rewrite): (String, &Rewrite)| {
        let mut by_uri = edits(view, &rewrite.edits);
        let added = match view.project {
            Some(project) => dependencies(view.report, project, rewrite, |_| Ok(None)).ok()?,
            None if rewrite.is_dependency => Vec::new(),
            None => return None,
        };
        let title = if added.is_empty() { title } else { format!("{title}, with `ceid-core` as a dependency") };
        for (path, at, text) in added {
            let manifest = view.report.manifests.get(&path)?;
            let place = Lines::new(manifest).position(at, view.client.encoding);
            let edit = TextEdit { range: Range { start: place, end: place }, new_text: text };
            by_uri.entry(view.documents.uri_of(&identity(&path))).or_default().push(edit);
        }
        Some(json!({ "title": title, "kind": REWRITE, "edit": workspace_edit(view, by_uri) }))
    };
    plan.rewrites().into_iter().filter_map(action).collect()
}

fn edits(view: &View<'_>, edits: &[(Span, String)]) -> BTreeMap<String, Vec<TextEdit>> {
    let mut by_uri: BTreeMap<String, Vec<TextEdit>> = BTreeMap::new();
    for (span, text) in edits {
        let edit = TextEdit { range: view.location(*span).range, new_text: text.clone() };
        by_uri.entry(view.uri(span.file)).or_default().push(edit);
    }
    by_uri
}

/// Whether a finding, the head of its cycle or one of its suggestions is on the lines of a range of this file.
fn is_on(view: &View<'_>, finding: &Diagnostic, range: Range) -> bool {
    let edits = finding.suggestions.iter().flat_map(|suggestion| &suggestion.edits).map(|(span, _)| *span);
    let mut places = [finding.primary.span].into_iter().chain(finding.facts.cycle).chain(edits);
    places.any(|span| {
        let own = view.range(span);
        // What ends with a line break ends before the line behind it.
        let last = if own.end.character == 0 { own.end.line.saturating_sub(1) } else { own.end.line };
        span.file == view.file && own.start.line <= range.end.line && range.start.line <= last.max(own.start.line)
    })
}

/// The client's own copies of a finding.
fn about(view: &View<'_>, finding: &Diagnostic, copies: &[Value]) -> Vec<Value> {
    let code = format!("ceid::{}", finding.rule);
    let range = (finding.primary.span.file == view.file).then(|| json!(view.range(finding.primary.span)));
    let is_copy = |copy: &&Value| copy["code"] == *code && range.as_ref().is_some_and(|range| copy["range"] == *range);
    copies.iter().filter(is_copy).cloned().collect()
}

fn fix(view: &View<'_>, suggestion: &Suggestion, about: &[Value]) -> Value {
    json!({
        "title": suggested(suggestion),
        "kind": QUICK_FIX,
        "diagnostics": about,
        "isPreferred": suggestion.applicability == Applicability::MachineApplicable,
        "edit": workspace_edit(view, edits(view, &suggestion.edits)),
    })
}

fn workspace_edit(view: &View<'_>, by_uri: BTreeMap<String, Vec<TextEdit>>) -> Value {
    if view.client.takes_versioned_edits {
        let version = |uri: &str| view.documents.path_of(uri).and_then(|path| Some(view.documents.get(&path)?.version));
        let changes = by_uri
            .into_iter()
            .map(|(uri, edits)| json!({ "textDocument": { "uri": uri, "version": version(&uri) }, "edits": edits }));
        return json!({ "documentChanges": changes.collect::<Vec<_>>() });
    }
    json!({ "changes": by_uri })
}

/// Writes a suppression above the line of the finding; its reason is left to the user.
fn suppression(view: &View<'_>, finding: &Diagnostic, about: &[Value]) -> Option<Value> {
    let is_about_suppressions = rules::find(finding.rule)?.group == Group::Hygiene;
    if finding.level == Level::Forbid || is_about_suppressions {
        return None;
    }
    let (file, offset) = suppressible(view, finding);
    let text = &view.report.sources.file(file).text;
    let lines = Lines::new(text);
    let line = lines.line_of(offset);
    let start = lines.bytes(line).start;
    let own = lines.line(line);
    let indentation = &own[..own.len() - own.trim_start().len()];
    let ending = if text[lines.bytes(line).end..].starts_with("\r\n") { "\r\n" } else { "\n" };
    let new_text = format!("{indentation}// ceid: allow({}, reason = \"…\"){ending}", finding.rule);
    let edit = TextEdit { range: lines.range(start..start, view.client.encoding), new_text };
    Some(json!({
        "title": format!("suppress `ceid::{}` here, with a reason", finding.rule),
        "kind": QUICK_FIX,
        "diagnostics": about,
        "edit": workspace_edit(view, [(view.uri(file), vec![edit])].into()),
    }))
}

/// The place above which a suppression stands for the finding: its own line, or that of its cycle's head where the line begins
/// with another statement or with the end of one, or where the same would be found at another place.
fn suppressible(view: &View<'_>, finding: &Diagnostic) -> (FileId, usize) {
    let own = finding.primary.span;
    let begins_with_it = |span: Span| {
        let text = &view.report.sources.file(span.file).text;
        let before = text.get(..span.start as usize).unwrap_or_default();
        let line = before.rsplit('\n').next().unwrap_or_default();
        // What stands above a closing bracket stands above no code.
        let is_closing =
            text.get(before.len() - line.len()..).unwrap_or_default().trim_start().starts_with(['}', ')', ']']);
        !line.contains(';') && !is_closing
    };
    let cycle = finding.facts.cycle.and_then(|head| view.report.cycles.iter().find(|cycle| cycle.head == head));
    let pairs = cycle.into_iter().flat_map(|cycle| &cycle.filters);
    let mut pairs =
        pairs.filter(|pair| finding.facts.filters.contains(&pair.name) && pair.rules.contains(&finding.rule));
    let is_elsewhere = pairs.any(|pair| !pair.others.is_empty());
    let head = finding.facts.cycle.filter(|head| (is_elsewhere || !begins_with_it(own)) && begins_with_it(*head));
    let span = head.unwrap_or(own);
    (span.file, span.start as usize)
}

fn explanation(view: &View<'_>, rule: &str) -> Value {
    let title = format!("explain `ceid::{rule}`");
    let command = json!({ "title": title, "command": explain::COMMAND, "arguments": [rule] });
    if view.client.takes_actions { json!({ "title": title, "kind": QUICK_FIX, "command": command }) } else { command }
}
