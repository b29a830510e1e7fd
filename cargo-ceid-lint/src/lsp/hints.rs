//! Hints behind the heads of cycles: what is proved there.

use serde_json::{Value, json};

use super::protocol::Range;
use super::view::View;
use crate::count::{Cycle, Verdict};

/// The hints of the cycles in a range.
pub(super) fn hints(view: &View<'_>, range: Range) -> Vec<Value> {
    let cycles = view.report.cycles.iter().filter(|cycle| cycle.head.file == view.file);
    let hints = cycles.filter_map(|cycle| {
        let line = view.lines.line_of(cycle.head.start as usize);
        let position = view.lines.position(view.lines.bytes(line).end, view.client.encoding);
        let is_shown = range.start.line <= position.line && position.line <= range.end.line;
        let label = proved(cycle).filter(|_| is_shown)?;
        Some(json!({ "position": position, "label": label, "paddingLeft": true }))
    });
    hints.collect()
}

/// `proved: kf, pf once per cycle; gyro once per sample`
fn proved(cycle: &Cycle) -> Option<String> {
    let mut groups: Vec<(&str, Vec<&str>)> = Vec::new();
    for pair in cycle.filters.iter().filter(|pair| pair.is_proved()) {
        let how = match pair.verdict {
            Verdict::OnceOrReset => "once per cycle or reset",
            Verdict::PerSample => "once per sample",
            Verdict::Gated => "once when the gate opens",
            _ => "once per cycle",
        };
        match groups.iter_mut().find(|(other, _)| *other == how) {
            Some((_, names)) => names.push(&pair.name),
            None => groups.push((how, vec![&pair.name])),
        }
    }
    let groups: Vec<String> = groups.into_iter().map(|(how, names)| format!("{} {how}", names.join(", "))).collect();
    (!groups.is_empty()).then(|| format!("proved: {}", groups.join("; ")))
}
