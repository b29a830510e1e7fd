//! What is said of filters that a path of a cycle goes past.

use super::find;
use super::findings::{GUARD_HELP, by_half, names, others, start, suppression};
use crate::count::{Cycle, ENDS_EARLY, GOES_ON, NO_RESET, OF_COPY, OTHER_RATE, Pair, TAKEN};
use crate::diagnostic::{Diagnostic, WitnessStep};

/// In one of how many cycles a gate opens, and what is claimed for it.
fn rates(message: &str) -> Option<(&str, &str)> {
    let (found, rest) = message.strip_prefix(OTHER_RATE)?.split_once(' ')?;
    let (_, claimed) = rest.rsplit_once(' ')?;
    Some((found, claimed))
}

pub(super) fn skipped(cycle: &Cycle, pairs: &[&Pair]) -> Option<Diagnostic> {
    let rule = find("skipped_update")?;
    let (verb, them) = if pairs.len() == 1 { ("is", "it") } else { ("are", "them") };
    let message = format!("{} {verb} not updated{} on a path through this cycle", names(pairs), by_half(cycle, pairs));
    let place = pairs[0].primary?;
    // Where no statement skips, the condition stands for what is not taken: it has to say which way that is.
    let is_condition = |step: &&WitnessStep| step.span == place && step.message.starts_with(TAKEN);
    let condition = pairs[0].witness.iter().find(is_condition).and_then(|step| step.message.strip_prefix(TAKEN));
    let when = condition.map(|condition| format!("when {condition}, ")).unwrap_or_default();
    let mut finding =
        start(rule, cycle, pairs, message, place, &format!("{when}this path goes on without updating {them}"));
    let is_lost = |pair: &&Pair| pair.witness.iter().any(|step| step.message == OF_COPY);
    if let Some(Pair { name, .. }) = pairs.iter().copied().find(is_lost) {
        finding.primary.message = format!("this path goes on without the updated copy of `{name}`");
        finding.helps.push(format!(
            "put the copy back in the place of `{name}` on each path, or reset `{name}` where it is not"
        ));
    }
    let mut steps = pairs.iter().flat_map(|pair| &pair.witness);
    if let Some((step, (found, claimed))) = steps.find_map(|step| Some((step, rates(&step.message)?))) {
        finding.message =
            format!("{} {verb} updated in one of {found} cycles, where one of {claimed} is claimed", names(pairs));
        finding.primary.message.clone_from(&step.message);
        finding.notes.push(format!(
            "`// ceid: every({claimed})` is a promise about the gate: whoever reads it takes the filter's step for {claimed} cycles"
        ));
        finding.notes.extend(others(pairs));
        finding.helps.push(format!("claim `every({found})`, or let the gate open in one of {claimed} cycles"));
        finding.helps.push(suppression(rule));
        return Some(finding);
    }
    let mut steps = pairs.iter().flat_map(|pair| &pair.witness);
    if let Some(step) = steps.find(|step| step.message.ends_with(ENDS_EARLY)) {
        finding.primary.message.clone_from(&step.message);
    }
    let stands = if pairs.len() == 1 { "it stands" } else { "they stand" };
    finding.notes.push(format!(
        "the cycles in which {stands} still are lost: no later step covers them, and the filter's time runs slower than the real one"
    ));
    finding.notes.extend(others(pairs));
    let is_told = |end: &str| pairs.iter().flat_map(|pair| &pair.witness).any(|step| step.message.ends_with(end));
    let clock = pairs.iter().flat_map(|pair| &pair.witness).find_map(|step| step.message.strip_suffix(GOES_ON));
    finding.helps.push(match () {
        () if is_told(NO_RESET) => {
            format!("reset {them} in full at each such change: the pause is a mode then")
        }
        () if is_told(ENDS_EARLY) => {
            format!("update {them} in a loop of {}, and ask behind that", if pairs.len() == 1 { "its own" } else { "their own" })
        }
        () if clock.is_some() => {
            let clock = clock.unwrap_or_default();
            let set = if clock.starts_with('`') { "set" } else { "read" };
            let is = if pairs.len() == 1 { "it is" } else { "they are" };
            format!(
                "update {them} before the paths part, or let the step be the time since the last update: {set} {clock} only where {is} updated"
            )
        }
        () => format!("update {them} before the paths part, or reset {them} on the path that skips"),
    });
    finding.helps.push(GUARD_HELP.to_owned());
    finding.helps.push(suppression(rule));
    Some(finding)
}
