//! What is wrong with the suppressions themselves.

use super::findings::{empty, quoted};
use super::known::Known;
use super::{GROUPS, RULES, Rule, find};
use crate::config::spelling::nearest;
use crate::diagnostic::{Applicability, Diagnostic, Label, Suggestion};
use crate::source::Span;
use crate::suppress::Placed;
use crate::syntax::{NearMiss, Suppression};

const UNUSED: &str = "unused_suppression";

/// The findings about suppressions; those about other code have to be known already.
#[must_use]
pub fn hygiene(known: &Known<'_>) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let suppressions = known.suppressions;
    found.extend(suppressions.near_misses.iter().filter_map(near_miss));
    for placed in &suppressions.list {
        if placed.said.rules.is_empty() {
            found.extend(blanket(placed));
        }
        found.extend(placed.said.rules.iter().filter_map(|(name, span)| unknown(placed, name, *span)));
    }
    for finding in &mut found {
        hide(known, finding);
    }
    // What hides a finding about a suppression is used; of two such, the inner one comes last.
    for of_hygiene in [false, true] {
        for number in (0..suppressions.list.len()).rev() {
            if let Some(mut finding) = unused(known, number, of_hygiene) {
                hide(known, &mut finding);
                found.push(finding);
            }
        }
    }
    found
}

fn hide(known: &Known<'_>, finding: &mut Diagnostic) {
    let hidden = known.hides(finding.rule, finding.package, &[finding.primary.span], &[]);
    finding.suppressed = hidden.map(|hidden| hidden.reason);
}

fn start<T>(rule: &'static Rule, placed: &Placed<T>, message: String, span: Span, label: &str) -> Diagnostic {
    let primary = Label { span, message: label.to_owned() };
    Diagnostic { message, primary, ..empty(rule, placed.package, placed.target) }
}

fn near_miss(placed: &Placed<NearMiss>) -> Option<Diagnostic> {
    let rule = find("unknown_rule")?;
    let said = &placed.said;
    let mut finding = start(rule, placed, said.message.clone(), placed.span, "this has no effect");
    finding.notes.push("until it is written as a directive, nobody reads it".to_owned());
    finding.suggestions.extend(said.correction.clone().map(|(span, text)| Suggestion {
        message: "write".to_owned(),
        edits: vec![(span, text)],
        applicability: if said.is_certain { Applicability::MachineApplicable } else { Applicability::MaybeIncorrect },
    }));
    Some(finding)
}

fn blanket(placed: &Placed<Suppression>) -> Option<Diagnostic> {
    let rule = find("blanket_suppression")?;
    let message = "this suppression names no rule, so it suppresses nothing".to_owned();
    let mut finding = start(rule, placed, message, placed.span, "which findings?");
    finding.notes.push("what would hide everything would hide the next mistake as well".to_owned());
    let word = word(&placed.said);
    finding.helps.push(format!("name the rules: `{word}(skipped_update, reason = \"…\")`"));
    Some(finding)
}

fn unknown(placed: &Placed<Suppression>, name: &str, span: Span) -> Option<Diagnostic> {
    let rule = find("unknown_rule")?;
    if find(name).is_some() {
        return None;
    }
    let plain = name.strip_prefix("ceid::").unwrap_or(name);
    let mut finding = start(rule, placed, format!("unknown rule `{name}`"), span, "there is no such rule");
    let rules = || RULES.iter().map(|rule| rule.name);
    if let Some(group) = GROUPS.iter().find(|group| group.name() == plain) {
        finding.message = format!("`{plain}` is a group: a suppression names each rule");
        "this suppresses nothing".clone_into(&mut finding.primary.message);
        let names: Vec<String> =
            RULES.iter().filter(|rule| rule.group == *group).map(|rule| rule.name.to_owned()).collect();
        finding.helps.extend((!names.is_empty()).then(|| format!("its rules are {}", quoted(&names))));
    } else if let Some(right) = nearest(&plain.replace('-', "_"), rules()) {
        finding.suggestions.push(Suggestion {
            message: "there is a rule of a similar name".to_owned(),
            edits: vec![(span, right.to_owned())],
            applicability: Applicability::MaybeIncorrect,
        });
    } else {
        finding.helps.push("`cargo ceid-lint rules` lists all rules".to_owned());
    }
    Some(finding)
}

/// The names in a suppression that no finding was found for.
fn unused(known: &Known<'_>, number: usize, of_hygiene: bool) -> Option<Diagnostic> {
    let rule = find(UNUSED)?;
    let placed = &known.suppressions.list[number];
    let rules = &placed.said.rules;
    let is_unused = |at: usize| {
        let found = find(&rules[at].0);
        found.is_some_and(|rule| (rule.name == UNUSED) == of_hygiene) && !known.is_used(number, at)
    };
    let unused: Vec<usize> = (0..rules.len()).filter(|at| is_unused(*at)).collect();
    if unused.is_empty() || !placed.is_placed {
        return None;
    }
    let names: Vec<String> = unused.iter().map(|at| rules[*at].0.clone()).collect();
    let said = if placed.said.is_expected { "expected" } else { "allowed" };
    let (are, is_none) =
        if names.len() == 1 { ("is", "there is no such finding") } else { ("are", "there are no such findings") };
    let message = format!("{} {are} {said} here, and {is_none}", quoted(&names));
    let is_whole = unused.len() == rules.len();
    let span = if is_whole { placed.span } else { rules[unused[0]].1 };
    let mut finding = start(rule, placed, message, span, "this hides nothing");
    if placed.reach.is_empty() {
        finding.notes.push("no code follows it that it could stand for".to_owned());
    }
    finding.notes.push("left where it is, it hides a mistake that is made here later".to_owned());
    let (message, edits) = if is_whole {
        ("remove the suppression".to_owned(), vec![(placed.removal, String::new())])
    } else {
        let edits = unused.iter().map(|at| (without(rules, &unused, *at), String::new())).collect();
        (format!("remove {}", quoted(&names)), edits)
    };
    finding.suggestions.push(Suggestion { message, edits, applicability: Applicability::MachineApplicable });
    Some(finding)
}

/// A name of a list with the comma that goes with it.
fn without(rules: &[(String, Span)], unused: &[usize], at: usize) -> Span {
    let own = rules[at].1;
    let has_kept_before = (0..at).any(|before| !unused.contains(&before));
    if has_kept_before {
        Span { start: rules[at - 1].1.end, ..own }
    } else {
        Span { end: rules.get(at + 1).map_or(own.end, |(_, next)| next.start), ..own }
    }
}

fn word(said: &Suppression) -> &'static str {
    if said.is_expected { "expect" } else { "allow" }
}
