//! What is said of the place under the cursor: the verdicts of a cycle or a filter, and what a rule is about.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::protocol::Position;
use super::view::View;
use crate::count::{Cycle, CycleKind, Pair, Verdict};
use crate::report::proof::counts;
use crate::rules::{self, Rule};
use crate::source::Span;

/// The text for a place, if there is something to say.
pub(super) fn hover(view: &View<'_>, position: Position) -> Option<Value> {
    let offset = view.lines.offset(position, view.client.encoding);
    let mut paragraphs = Vec::new();
    let mut rules: BTreeSet<&str> = BTreeSet::new();
    let mut place: Option<Span> = None;
    for finding in view.findings().filter(|finding| view.holds(finding.primary.span, offset)) {
        place.get_or_insert(finding.primary.span);
        rules.insert(finding.rule);
        paragraphs.push(format!("**`ceid::{}`**: {}", finding.rule, finding.message));
    }
    for cycle in view.report.cycles.iter().filter(|cycle| view.holds(cycle.head, offset)) {
        place.get_or_insert(cycle.head);
        rules.extend(cycle.filters.iter().flat_map(|pair| &pair.rules));
        paragraphs.push(of_cycle(cycle));
    }
    for cycle in view.report.cycles.iter().filter(|cycle| !view.holds(cycle.head, offset)) {
        for pair in &cycle.filters {
            let mut places = pair.updates.iter().chain(&pair.primary);
            if let Some(span) = places.find(|span| view.holds(**span, offset)) {
                place.get_or_insert(*span);
                rules.extend(&pair.rules);
                let line = view.report.sources.line(cycle.head);
                paragraphs.push(format!("{}\n\nIn the {} on line {line}.", of_pair(pair), kind(cycle)));
            }
        }
    }
    let named = named_rule(view, offset);
    if let Some((rule, span)) = &named {
        place = Some(*span);
        rules.insert(rule.name);
    }
    let place = place?;
    paragraphs.dedup();
    // What is allowed is no news.
    let is_named = |rule: &str| named.as_ref().is_some_and(|(named, _)| named.name == rule);
    rules.retain(|rule| is_named(rule) || view.report.diagnostics.iter().any(|finding| finding.rule == *rule));
    paragraphs.extend(rules.into_iter().filter_map(rules::find).map(page));
    let text = paragraphs.join("\n\n---\n\n");
    let format = if view.client.renders_markdown { "markdown" } else { "plaintext" };
    Some(json!({
        "contents": { "kind": format, "value": text },
        "range": view.range(place),
    }))
}

/// The text of a rule, with headings that do not fill the box.
fn page(rule: &Rule) -> String {
    let mut is_code = false;
    let lines = rule.explanation.trim().lines().map(|line| {
        is_code ^= line.starts_with("```");
        let is_heading = !is_code && line.starts_with('#');
        format!("{}{line}", if is_heading { "##" } else { "" })
    });
    lines.collect::<Vec<_>>().join("\n")
}

fn kind(cycle: &Cycle) -> String {
    match cycle.kind {
        CycleKind::Function => format!("cycle function `{}`", cycle.function),
        kind => format!("`{}` of `{}`", kind.name(), cycle.function),
    }
}

fn of_cycle(cycle: &Cycle) -> String {
    let pairs: Vec<String> = cycle.filters.iter().map(|pair| format!("- {}", of_pair(pair))).collect();
    if pairs.is_empty() {
        return "A control cycle that has to do with no filter.".to_owned();
    }
    format!("In one iteration of this control cycle:\n\n{}", pairs.join("\n"))
}

/// `kf` (`KalmanF`): **skipped**, 0 or 1 updates in one iteration
fn of_pair(pair: &Pair) -> String {
    let how = match (pair.verdict, &pair.cause) {
        (Verdict::Unproved, Some(cause)) => cause.clone(),
        (Verdict::Gated, _) => {
            let gate = pair.gate.map_or(String::new(), |gate| format!("{} ", gate.name()));
            format!("updated exactly once whenever its {gate}gate opens")
        }
        (Verdict::Guarded, _) => "updated exactly once, by a guard".to_owned(),
        (Verdict::OnceOrReset, _) => "updated exactly once, or reset".to_owned(),
        (Verdict::PerSample, _) => "updated exactly once for every sample".to_owned(),
        (Verdict::Once, _) => "updated exactly once on every path".to_owned(),
        _ => format!("{} updates", counts(pair)),
    };
    let suppressed = match pair.suppressed.as_deref() {
        None if pair.known => "; known".to_owned(),
        None => String::new(),
        Some("") => "; suppressed".to_owned(),
        Some(reason) => format!("; suppressed: {reason}"),
    };
    let verdict = pair.verdict.name().replace('_', " ");
    format!("`{}` (`{}`): **{verdict}**, {how}{suppressed}", pair.name, pair.filter_type)
}

/// The rule that a comment or an attribute names under the cursor.
fn named_rule(view: &View<'_>, offset: usize) -> Option<(&'static Rule, Span)> {
    let line = view.lines.line_of(offset);
    let (text, start) = (view.lines.line(line), view.lines.bytes(line).start);
    if !text.contains("ceid:") {
        return None;
    }
    let at = offset.checked_sub(start)?;
    let is_part = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
    let before = text.get(..at)?;
    let begin = before.trim_end_matches(is_part).len();
    let length = text.get(begin..)?.find(|letter| !is_part(letter)).unwrap_or(text.len() - begin);
    let to_u32 = |at: usize| u32::try_from(start + at).unwrap_or(u32::MAX);
    let span = Span::new(view.file, to_u32(begin), to_u32(begin + length));
    rules::find(text.get(begin..begin + length)?).map(|rule| (rule, span))
}
