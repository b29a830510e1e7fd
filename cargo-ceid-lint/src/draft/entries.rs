//! One entry of the file: what it is about, why, and its keys.

use std::fmt::Write as _;

use super::places::Places;
use super::prose::{comment, list, times};
use crate::candidates::{CycleCandidate, CycleReason, CycleTarget, FilterCandidate, Reason, Subject, Uses};
use crate::config::{InstancePlace, Multiplicity, Receiver, TimeBase};

/// Writes a `[[filter]]` with its reasons.
pub(super) fn filter(text: &mut String, filter: &FilterCandidate, places: &Places<'_>, is_on: bool) {
    let name = filter.path.rsplit("::").next().unwrap_or(&filter.path);
    let place = filter.place.map(|place| format!(" ({})", places.of(place))).unwrap_or_default();
    let reasons: Vec<String> = filter.reasons.iter().map(because).collect();
    text.push('\n');
    comment(text, &format!("`{name}`{place}: {}; {}.", reasons.join("; "), used(filter.uses)));
    let mut lines = vec!["[[filter]]".to_owned()];
    let key = match filter.subject {
        Subject::Type => "type",
        Subject::Trait => "trait",
        Subject::Function => "function",
    };
    lines.push(format!("{key} = {}", quoted(&filter.path)));
    if filter.subject != Subject::Function {
        lines.push(format!("law = {}", law(&filter.law)));
        if filter.law.len() > 1 {
            let words: Vec<String> = filter.law.iter().map(|(_, times)| quoted(word(*times))).collect();
            lines.push(format!("multiplicity = [{}]", words.join(", ")));
        }
    }
    match (filter.instance, filter.subject) {
        (InstancePlace::Receiver, _) | (InstancePlace::Argument(0), Subject::Function) => {}
        (InstancePlace::Argument(position), _) => lines.push(format!("instance = \"arg({position})\"")),
        (InstancePlace::Returned, _) => lines.push("instance = \"returned\"".to_owned()),
    }
    if filter.receiver == Receiver::Shared {
        lines.push("receiver = \"shared\"".to_owned());
    }
    for (key, names) in [("reset", &filter.resets), ("partial_reset", &filter.partial_resets)] {
        if !names.is_empty() {
            let names: Vec<String> = names.iter().map(|name| quoted(name)).collect();
            lines.push(format!("{key} = [{}]", names.join(", ")));
        }
    }
    lines.extend(filter.key.map(|key| format!("key = {key}")));
    match filter.time_base {
        TimeBase::Fixed => {}
        TimeBase::Passed => lines.push("time_base = \"passed\"".to_owned()),
        TimeBase::Inside => lines.push("time_base = \"inside\"".to_owned()),
    }
    write_lines(text, &lines, is_on);
}

/// Writes a `[[cycle]]` with its reason.
pub(super) fn cycle(text: &mut String, cycle: &CycleCandidate, places: &Places<'_>, is_on: bool) {
    let place = places.of(cycle.place);
    let why = match cycle.reason {
        CycleReason::Attribute => "its attribute is that of a handler or task",
        CycleReason::Exported => "it is exported, as handlers are",
        CycleReason::HandedOver => "its name is handed to another function, as that of a callback",
        CycleReason::Framework => "it implements a method of a framework",
        CycleReason::NotCalled => "nothing that was read calls it",
    };
    let path = cycle.target.path();
    let mut parts = path.rsplitn(3, "::");
    let name = match (parts.next(), parts.next()) {
        (Some(name), Some(owner)) if owner.starts_with(char::is_uppercase) => format!("{owner}::{name}"),
        _ => path.rsplit("::").next().unwrap_or(path).to_owned(),
    };
    let others = match cycle.functions {
        0 | 1 => String::new(),
        count => format!(" and {} more", count - 1),
    };
    text.push('\n');
    comment(
        text,
        &format!("`{name}` ({place}{others}): {why}, and it runs {}.", crate::report::count(cycle.laws, "update law")),
    );
    let key = match cycle.target {
        CycleTarget::Function(_) => "function",
        CycleTarget::Method(_) => "method",
        CycleTarget::Attribute(_) => "attribute",
    };
    write_lines(text, &["[[cycle]]".to_owned(), format!("{key} = {}", quoted(path))], is_on);
}

fn write_lines(text: &mut String, lines: &[String], is_on: bool) {
    for line in lines {
        let _ = writeln!(text, "{}{line}", if is_on { "" } else { "#" });
    }
}

fn because(reason: &Reason) -> String {
    match reason {
        Reason::Carries(law, fields) => format!("`{law}` computes {} from the value before", list(fields)),
        Reason::Changes(law, fields) => format!("`{law}` changes {}", list(fields)),
        Reason::Runs(law, fields) => format!("`{law}` runs the update laws of {}", list(fields)),
        Reason::GivesBack(law, state) => format!("`{law}` gives back the next `{state}`"),
        Reason::Implemented(types) => format!("a trait that {} like a filter", times_types(*types)),
        Reason::Named(_) => "its name is that of a filter".to_owned(),
        Reason::Timed(law) => format!("`{law}` is told the time step"),
        Reason::Tuned(fields) => format!("tuned by {}", list(fields)),
        Reason::Unread(name, methods) => {
            format!("the crate of `{name}` was not read, and {} called on it", list_are(methods))
        }
    }
}

fn times_types(types: usize) -> String {
    if types == 1 { "one type implements".to_owned() } else { format!("{types} types implement") }
}

fn list_are(names: &[String]) -> String {
    format!("{} {}", list(names), if names.len() == 1 { "is" } else { "are" })
}

fn used(uses: Uses) -> String {
    match (uses.calls, uses.in_cycles) {
        (0, _) if uses.by_trait > 0 => "called through a trait, where other types may be meant".to_owned(),
        (0, _) => "no call of it was read".to_owned(),
        (calls, 0) => format!("called {}", times(calls)),
        (1, 1) => "called once, in a cycle".to_owned(),
        (calls, in_cycles) if calls == in_cycles => format!("called {}, each in a cycle", times(calls)),
        (calls, 1) => format!("called {}, one of them in a cycle", times(calls)),
        (calls, in_cycles) => format!("called {}, {in_cycles} of them in cycles", times(calls)),
    }
}

fn law(groups: &[(Vec<String>, Multiplicity)]) -> String {
    if let [(methods, _)] = groups
        && let [only] = methods.as_slice()
    {
        return quoted(only);
    }
    let groups: Vec<String> = groups
        .iter()
        .map(|(methods, _)| {
            let methods: Vec<String> = methods.iter().map(|method| quoted(method)).collect();
            format!("[{}]", methods.join(", "))
        })
        .collect();
    format!("[{}]", groups.join(", "))
}

fn word(multiplicity: Multiplicity) -> &'static str {
    match multiplicity {
        Multiplicity::Once => "once",
        Multiplicity::AtMostOnce => "at-most-once",
        Multiplicity::Any => "any",
    }
}

fn quoted(text: &str) -> String {
    format!("\"{text}\"")
}
