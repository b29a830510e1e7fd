//! What is said of filters that no path of a cycle updates.

use super::find;
use super::findings::{GUARD_HELP, by_half, names, others, start, suppression};
use crate::count::{Cycle, OF_COPY, Pair, UNAWAITED, UNCALLED, UNCONSUMED};
use crate::diagnostic::{Diagnostic, WitnessStep};

pub(super) fn missing(cycle: &Cycle, pairs: &[&Pair]) -> Option<Diagnostic> {
    let rule = find("missed_update")?;
    let (verb, them) = if pairs.len() == 1 { ("is", "it") } else { ("are", "them") };
    let message = format!("{} {verb} never updated{} in this cycle", names(pairs), by_half(cycle, pairs));
    let label = format!("no path through this cycle updates {them}{}", by_half(cycle, pairs));
    let mut finding = start(rule, cycle, pairs, message, pairs[0].primary?, &label);
    // Behind the head of the cycle, they tell where something is written that is taken for an update.
    let reasons = pairs.iter().flat_map(|pair| pair.witness.iter().skip(1).map(|step| (*pair, step)));
    let mut told: Vec<WitnessStep> = Vec::new();
    for (pair, step) in reasons {
        if !told.contains(step) {
            let (note, help) = reason(pair, step);
            finding.notes.push(note);
            finding.helps.push(help);
            told.push(step.clone());
        }
    }
    finding.witness.steps = match told.as_slice() {
        [] => Vec::new(),
        _ => pairs[0].witness.first().cloned().into_iter().chain(told).collect(),
    };
    if finding.notes.is_empty() {
        let stands = match pairs {
            [_] => {
                "a filter whose update law does not run keeps its old estimate: whatever reads it gets a value that stands still"
            }
            _ => {
                "filters whose update laws do not run keep their old estimates: whatever reads them gets values that stand still"
            }
        };
        finding.notes.push(stands.to_owned());
        finding.helps.push(format!("update {them} once in every cycle, or {}", GUARD_HELP.replacen("it", them, 1)));
    }
    finding.notes.dedup();
    finding.helps.dedup();
    finding.notes.extend(others(pairs));
    finding.helps.push(suppression(rule));
    Some(finding)
}

/// Why what is written at a step is no update of the filter, and what makes one of it.
fn reason(Pair { name, law, .. }: &Pair, step: &WitnessStep) -> (String, String) {
    if step.message == OF_COPY {
        return (
            format!(
                "each cycle begins with the same state again: `{name}` stands still, and its copy is ahead of it by one cycle at most"
            ),
            format!("update `{name}` itself, or put the copy back in its place"),
        );
    }
    if let Some(adaptor) = step.message.strip_prefix(UNCONSUMED).and_then(|rest| rest.split('`').next()) {
        let help = match adaptor {
            "map" | "inspect" => {
                format!("run it for each element: `for_each` in the place of `{adaptor}`, or a `for` loop")
            }
            _ => "run it for each element, with a `for` loop or `for_each`".to_owned(),
        };
        return (format!("`{adaptor}` is lazy: its closure runs when something takes the items, and not before"), help);
    }
    if step.message.starts_with(UNCALLED) {
        return ("a closure does nothing before it is called".to_owned(), "call it once in every cycle".to_owned());
    }
    if step.message.starts_with(UNAWAITED) {
        return ("a future does nothing before it is awaited".to_owned(), "await it: `.await`".to_owned());
    }
    (
        format!("`{law}` gives back the next state and changes nothing: `{name}` stands still here"),
        format!("put what `{law}` gives back in the place of `{name}`"),
    )
}
