//! The words of the rules that no verdict stands for. Decides nothing.

use super::find;
use super::findings::{GUARD_HELP, empty, suppression};
use crate::count::{Fact, Remark, Verdict};
use crate::diagnostic::{Diagnostic, Facts, Label, Witness};
use crate::flow::WaitKind;

/// The finding that tells a remark.
pub(super) fn finding(remark: &Remark) -> Option<Diagnostic> {
    let rule = find(remark.fact.rule())?;
    let words = words(remark);
    let mut finding = empty(rule, remark.package, remark.target);
    finding.message = words.message;
    finding.primary = Label { span: remark.span, message: words.label };
    finding.witness = Witness { steps: remark.witness.clone() };
    finding.notes.push(words.note);
    finding.helps.extend(words.helps);
    finding.helps.push(suppression(rule));
    finding.facts = Facts {
        verdict: remark.verdict.map(|verdict| verdict.name().to_owned()).unwrap_or_default(),
        counts: remark.counts.clone(),
        filters: Some(remark.name.clone()).filter(|name| !name.is_empty()).into_iter().collect(),
        filter_type: remark.filter_type.clone(),
        cycle: remark.cycle,
        cause: None,
        function: remark.function.clone(),
    };
    Some(finding)
}

/// What a finding says.
struct Words {
    message: String,
    label: String,
    note: String,
    helps: Vec<String>,
}

fn words(remark: &Remark) -> Words {
    let name = &remark.name;
    match &remark.fact {
        Fact::DebugOnly { by } => debug_only(remark, by),
        Fact::MultiEvent => Words {
            message: format!(
                "`{name}` has a fixed step, and two different events of this loop advance it: its step no longer means anything"
            ),
            label: "advanced again here, for another event".to_owned(),
            note: "how much time lies between two updates depends on which events come, and the law assumes one sample time"
                .to_owned(),
            helps: vec![
                format!("advance `{name}` for one event only, or in a loop of its own with a clock"),
                "let the law be told how much time has passed".to_owned(),
            ],
        },
        Fact::TimeInCycle { kind, what } => in_cycle(*kind, what),
        Fact::RateMismatch { step, period } => Words {
            message: format!(
                "`{name}` is built for a step of {}, and its cycle runs every {}",
                time(*step),
                time(*period)
            ),
            label: format!("built for {} here", time(*step)),
            note: "with a wrong step every cut-off frequency, gain and time constant of the filter is off by the same factor"
                .to_owned(),
            helps: vec!["take both from one constant, or from the rate of the cycle's type".to_owned()],
        },
    }
}

fn debug_only(remark: &Remark, by: &str) -> Words {
    let name = &remark.name;
    let last = by.rsplit("::").next().unwrap_or(by);
    let is_log = !by.contains("debug_assertions") && !last.starts_with("debug_assert");
    let (place, off, on, label) = match is_log {
        true => (
            format!("in an argument of `{by}`"),
            "while that log level is off",
            "while that log level is on",
            "only a log level that is on runs this update",
        ),
        false => {
            let preposition = if by.ends_with('!') { "in" } else { "under" };
            (
                format!("{preposition} `{by}`"),
                "in a release build",
                "in a debug build",
                "only a debug build runs this update",
            )
        }
    };
    let message = match remark.verdict {
        Some(Verdict::Skipped) => {
            format!("`{name}` is updated on some path only {place}: {off} it stands still there")
        }
        None | Some(Verdict::Missed | Verdict::Unproved) => {
            format!("`{name}` is updated only {place}: {off} it stands still")
        }
        Some(_) => format!("`{name}` is updated once more {place}: {on} it runs ahead"),
    };
    Words {
        message,
        label: label.to_owned(),
        note: "what runs on the machine then differs from what was tried on the bench".to_owned(),
        helps: vec![
            "run the update as a statement of its own, and hand only its result to the check".to_owned(),
            GUARD_HELP.to_owned(),
        ],
    }
}

fn in_cycle(kind: WaitKind, what: &str) -> Words {
    let (message, label, note) = match kind {
        WaitKind::Sleep | WaitKind::Tick => (
            format!("`{what}` waits inside this control cycle, so that its period is the wait and all of its work"),
            "waits here",
            "each cycle is late by what the one before it took, and the filters' time runs slower than the real one",
        ),
        WaitKind::Clock => (
            format!("`{what}` reads a clock inside this control cycle, so that no two runs are alike"),
            "reads a clock here",
            "control code that is told its time can be tested and simulated; code that asks for it cannot",
        ),
        WaitKind::Io => (
            format!(
                "`{what}` may block inside this control cycle, so that the cycle lasts as long as the device likes"
            ),
            "may block here",
            "a cycle that waits for a device misses its next release",
        ),
        WaitKind::Lock => (
            format!(
                "`{what}` waits for a lock inside this control cycle, so that whoever holds it decides when it goes on"
            ),
            "waits for a lock here",
            "a thread of lower priority that holds the lock delays the cycle by any time",
        ),
    };
    let help = match kind {
        WaitKind::Sleep | WaitKind::Tick => {
            "let a clock release the cycles: a realtime thread, a ticker, `ceid_core::Clock`"
        }
        WaitKind::Clock => "let the cycle be told its time by the clock that releases it",
        WaitKind::Io | WaitKind::Lock => "exchange the data outside the cycle, and let the cycle take the latest of it",
    };
    Words { message, label: label.to_owned(), note: note.to_owned(), helps: vec![help.to_owned()] }
}

/// A time as people write it.
fn time(seconds: f64) -> String {
    let (value, unit) = match seconds {
        seconds if seconds >= 1.0 => (seconds, "s"),
        seconds if seconds >= 1e-3 => (seconds * 1e3, "ms"),
        seconds => (seconds * 1e6, "µs"),
    };
    let text = format!("{value:.3}");
    format!("{} {unit}", text.trim_end_matches('0').trim_end_matches('.'))
}

#[cfg(test)]
mod tests {
    use super::time;

    #[test]
    fn times_are_short() {
        assert_eq!(time(0.01), "10 ms");
        assert_eq!(time(1.0 / 60.0), "16.667 ms");
        assert_eq!(time(2.0), "2 s");
        assert_eq!(time(125e-6), "125 µs");
    }
}
