//! What is said of a filter that one cycle updates more than once, and of siblings that it was pasted over.

use std::collections::BTreeSet;

use super::find;
use super::findings::{GUARD_HELP, by_half, names, others, quoted, start, suppression};
use crate::count::{BY_CALL, BY_GUARD, CALL_REPEATS, Cycle, ORDINALS, Pair, TRADES, WAYS_AGAIN, macro_again};
use crate::diagnostic::{Diagnostic, WitnessStep};
use crate::source::Span;

/// Whether a sibling could stand where a pair is updated again: the law is called there, or a function with what tells the pair from
/// the sibling, and no procedure with the owner of both.
pub(super) fn can_be_sibling(pair: &Pair, sibling: &str) -> bool {
    let ends = pair.name.match_indices(['.', '[']).map(|(at, _)| at).chain([pair.name.len()]);
    let told_by = ends.map(|end| &pair.name[..end]).find(|owner| {
        let rest = sibling.strip_prefix(owner);
        rest.is_none_or(|rest| !rest.is_empty() && !rest.starts_with(['.', '[']))
    });
    let is_call = |step: &&WitnessStep| Some(step.span) == pair.primary && step.message.contains(BY_CALL);
    let says_so = |step: &WitnessStep| told_by.is_some_and(|owner| names_part(&step.message, owner));
    let mut calls = pair.witness.iter().filter(is_call);
    calls.clone().all(says_so) || calls.any(|step| is_told_which(&step.message))
}

/// Whether each round of an inner loop tells a function which filter it is for: `for leg in [Leg::Front, Leg::Rear] { legs.sense(leg) }`.
fn is_told_which(message: &str) -> bool {
    let call = message.strip_suffix(WAYS_AGAIN[0]).and_then(|message| message.split('`').nth(1));
    let args = call.and_then(|call| call.split_once('(')).map(|(_, args)| args.trim_end_matches(')'));
    let is_name = |arg: &str| {
        let name = arg.trim().trim_start_matches(['*', '&']);
        let is_word = name.chars().all(|char| char.is_lowercase() || char.is_ascii_digit() || char == '_');
        is_word && name.starts_with(char::is_lowercase) && name != "self"
    };
    args.is_some_and(|args| args.split(',').any(is_name))
}

/// Whether a text has a place in it, or what a pattern or an alias calls it by: `stage.left` for `self.stages[*].left`.
fn names_part(text: &str, place: &str) -> bool {
    let part = place.rfind('.').map(|dot| &place[dot + 1..]).filter(|part| !part.ends_with(']'));
    let is_name = |char: char| char.is_alphanumeric() || char == '_';
    let is_word = |(at, part): (usize, &str)| {
        let (before, behind) = (&text[..at], &text[at + part.len()..]);
        let is_number = part.starts_with(|char: char| char.is_ascii_digit());
        !before.ends_with(is_name) && !behind.starts_with(is_name) && (!is_number || before.ends_with('.'))
    };
    // `self.axis(1)` updates `self.pids[1]`.
    let key = place.strip_suffix(']').and_then(|place| place.rfind('[').map(|at| &place[at + 1..]));
    let is_given = |(at, key): (usize, &str)| {
        let is_around = |char: char| is_name(char) || char == '.' || char == ':';
        !text[..at].ends_with(is_around) && !text[at + key.len()..].starts_with(is_around)
    };
    text.contains(place)
        || part.is_some_and(|part| text.match_indices(part).any(is_word))
        || key.is_some_and(|key| text.match_indices(key).any(is_given))
}

/// The repeated filter of the same type that was written in place of a missed one: that with the most similar name.
pub(super) fn pasted_from<'p>(missed: &Pair, repeats: &[&'p Pair]) -> Option<&'p Pair> {
    let of_type = repeats.iter().filter(|pair| pair.filter_type == missed.filter_type);
    of_type.copied().min_by_key(|pair| strsim::osa_distance(&pair.name, &missed.name))
}

/// Whether two filters change places with each other between two updates.
pub(super) fn trades_with(one: &Pair, other: &Pair) -> bool {
    one.primary == other.primary && one.witness == other.witness && one.skips && other.skips && trades(one)
}

/// Whether one call is the second update of both filters: of what is in a composite, or of what a method updates side by side.
pub(super) fn is_updated_with(one: &Pair, other: &Pair) -> bool {
    one.primary == other.primary
        && one.skips == other.skips
        && one.half == other.half
        && second_call(one).is_some_and(|call| second_call(other) == Some(call))
}

/// The step of the call that is the second update, as the witness says it.
fn second_call(pair: &Pair) -> Option<&str> {
    let is_second = |step: &&WitnessStep| Some(step.span) == pair.primary && step.message.contains(BY_CALL);
    pair.witness.iter().rev().find(is_second).map(|step| step.message.as_str())
}

/// What a step of a call says that it runs, in the backticks of its source.
fn called(message: &str) -> Option<&str> {
    let (call, _) = message.rsplit_once(BY_CALL)?;
    call.find('`').map(|at| &call[at..])
}

/// The paths of filters that one call updates again, as one: what only some of them go through says whose it is.
fn together(group: &[&Pair]) -> Vec<WitnessStep> {
    let Some((first, rest)) = group.split_first() else { return Vec::new() };
    let is_shared = |step: &WitnessStep| group.iter().all(|pair| pair.witness.contains(step));
    let mut steps: Vec<WitnessStep> = Vec::new();
    let own = |pair: &Pair| {
        let name = pair.name.clone();
        let named = move |step: &WitnessStep| match step.message.strip_suffix(" update") {
            Some(_) if !is_shared(step) => {
                WitnessStep { message: format!("{} of `{name}`", step.message), ..step.clone() }
            }
            _ => step.clone(),
        };
        pair.witness.iter().map(named).collect::<Vec<_>>()
    };
    steps.extend(own(first));
    for step in rest.iter().flat_map(|pair| own(pair)) {
        if steps.contains(&step) {
            continue;
        }
        // Before the call, in the order of the source.
        let is_behind = |other: &WitnessStep| {
            Some(other.span) == first.primary || other.span.file == step.span.file && other.span.start > step.span.start
        };
        let at = steps.iter().skip(1).position(is_behind).map_or(steps.len(), |at| at + 1);
        steps.insert(at, step);
    }
    steps
}

fn trades(pair: &Pair) -> bool {
    pair.witness.iter().any(|step| step.message == TRADES)
}

fn is_call_that_repeats(message: &str) -> bool {
    message.strip_suffix(CALL_REPEATS).is_some_and(|rest| rest.ends_with(BY_CALL))
}

pub(super) fn repeated(cycle: &Cycle, pair: &Pair, siblings: &[&Pair], partners: &[&Pair]) -> Option<Diagnostic> {
    let rule = find("repeated_update")?;
    let left_out = pair.left_out.iter().filter(|sibling| can_be_sibling(pair, sibling)).cloned();
    let siblings: Vec<String> = siblings.iter().map(|sibling| sibling.name.clone()).chain(left_out).collect();
    let group: Vec<&Pair> = [pair].into_iter().chain(partners.iter().copied()).collect();
    let (verb, them) = if group.len() == 1 { ("is", "it") } else { ("are", "them") };
    let mut message = format!("{} {verb} updated{} more than once in one cycle", names(&group), by_half(cycle, &group));
    let is_one_call = !partners.is_empty() && !trades(pair);
    let by_call = second_call(pair).filter(|_| is_one_call).and_then(called);
    if let Some(call) = by_call {
        message.push_str(&format!(", by {call}"));
    }
    match (partners, pair.skips) {
        (_, true) if by_call.is_some() => message.push_str(", and not at all on another path"),
        (_, false) if by_call.is_some() => {}
        ([], true) if trades(pair) => message.push_str(", and not at all in another one"),
        ([], true) => message.push_str(" and not at all on another path"),
        ([], false) => {}
        _ => {
            message = format!(
                "{} change places between two updates: one of them is updated{} more than once in one cycle, and another one not at all",
                names(&group),
                by_half(cycle, &group)
            );
        }
    }
    if let Some(first) = siblings.first() {
        message.push_str(&format!(", and {} of the same type never: was `{first}` meant here?", quoted(&siblings)));
    }
    let primary = pair.primary?;
    // What runs twice at one place says how it comes there again.
    let leads_here = |how: &&str| pair.witness.iter().any(|step| step.span == primary && step.message.ends_with(*how));
    let by_other_guard = pair.witness.iter().any(|step| step.message.ends_with(WAYS_AGAIN[1]));
    let by_guard = pair.witness.iter().find(|step| step.message == BY_GUARD);
    let by_several_guards = pair.witness.iter().filter(|step| step.message == BY_GUARD).count() > 1;
    let is_by_hand = |step: &WitnessStep| ORDINALS.iter().any(|number| step.message.starts_with(number));
    let by_hand: BTreeSet<Span> = pair.witness.iter().filter(|step| is_by_hand(step)).map(|step| step.span).collect();
    let is_last = by_guard.is_some_and(|step| step.span == primary);
    let how = WAYS_AGAIN.into_iter().find(leads_here).unwrap_or(if is_last { ", by the guard" } else { "" });
    let is_at_call = |step: &WitnessStep| step.span == primary && is_told_which(&step.message);
    let by_rounds = pair.witness.iter().any(is_at_call);
    let of_macro = pair.witness.iter().filter(|step| step.span == primary).find_map(|step| macro_again(&step.message));
    let how = of_macro.map_or_else(|| how.to_owned(), |name| format!(": `{name}` writes it more than once"));
    // What a function does twice that is no part of the project is shown at the call.
    let is_whole_call = pair.witness.iter().any(|step| step.span == primary && is_call_that_repeats(&step.message))
        && pair.witness.last().is_some_and(|step| step.span != primary);
    let label = if is_whole_call { "updated more than once in this call" } else { "updated again here" };
    let mut finding = start(rule, cycle, &group, message, primary, &format!("{label}{how}"));
    finding.notes.extend(of_macro.map(|name| {
        format!("`{name}` writes down what it is given in more than one place of its code, and the update runs in each of them")
    }));
    finding.notes.push(format!(
        "the update law of a sampled-time filter advances it by one sample; run twice, {} is ahead of its measurements",
        if partners.is_empty() { format!("`{}`", pair.name) } else { "it".to_owned() }
    ));
    finding.notes.extend(others(&group));
    if is_one_call {
        finding.witness.steps = together(&group);
    }
    finding.helps.push(match siblings.as_slice() {
        [] if by_other_guard || by_several_guards && by_hand.is_empty() => {
            format!("register {} with one of the guards only", names(&group))
        }
        [] if by_guard.is_some() => format!("leave {} to the guard, and remove the update by hand", names(&group)),
        [] if is_one_call => format!("update each of {them} once: by this call, or where it is updated before"),
        [] if !partners.is_empty() => {
            "update all of them before they change places, or all of them behind that".to_owned()
        }
        [] if let Some(name) = of_macro => format!("update it before, and give `{name}` what comes of it"),
        [] if how == WAYS_AGAIN[0] && by_hand.len() < 2 => {
            "update it once for all rounds of the inner loop: behind it, with what they come to".to_owned()
        }
        [] => "keep one of the updates".to_owned(),
        siblings if by_rounds => format!("let one of the rounds come to {}", quoted(siblings)),
        siblings => format!("update {} here instead", quoted(siblings)),
    });
    finding.helps.extend(by_guard.is_none().then(|| GUARD_HELP.to_owned()));
    finding.helps.push(suppression(rule));
    finding.facts.filters.extend(siblings);
    Some(finding)
}
