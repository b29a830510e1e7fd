//! The words of the rules that no verdict stands for. Decides nothing.

use super::find;
use super::findings::{GUARD_HELP, empty, suppression};
use crate::count::{Fact, Remark, Verdict};
use crate::diagnostic::{Diagnostic, Facts, Label, Witness};

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
        Fact::DebugOnly { by } => {
            let (where_, when) = match by.strip_suffix('!') {
                _ if by.contains("debug_assertions") => (format!("under `{by}`"), "a debug build"),
                Some(path) if path.rsplit("::").next().unwrap_or("").starts_with("debug_assert") => {
                    (format!("in `{by}`"), "a debug build")
                }
                _ => (format!("in an argument of `{by}`"), "a log level that is switched on"),
            };
            let message = match remark.verdict {
                Some(Verdict::Skipped) => {
                    format!("`{name}` is updated on some paths only {where_}: without {when} it stands still there")
                }
                None | Some(Verdict::Missed | Verdict::Unproved) => {
                    format!("`{name}` is updated only {where_}: without {when} it stands still")
                }
                _ => format!("`{name}` is updated once more {where_}: with {when} it runs ahead"),
            };
            Words {
                message,
                label: format!("this update runs only with {when}"),
                note: "the filter must behave on the machine as it did on the bench".to_owned(),
                helps: vec![
                    "run the update on its own, and hand only its result to the macro".to_owned(),
                    GUARD_HELP.to_owned(),
                ],
            }
        }
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
    }
}
