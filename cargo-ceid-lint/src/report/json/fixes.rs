//! What was fixed, one JSON object a line before cargo's messages. Readers of those skip a `reason` that they do not know.

use serde::Serialize;

use super::push;
use crate::fix::{Fix, Revision};

/// What became of the fixes of a revision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FixOutcome {
    /// They are on the disk.
    Fixed,
    /// They would be, if it had not been asked what would happen.
    WouldFix,
    /// They are not, because writing failed.
    NotWritten,
    /// One of them cannot be made.
    Refused,
}

#[derive(Serialize)]
struct FixMessage<'a> {
    reason: &'static str,
    outcome: FixOutcome,
    code: String,
    message: &'a str,
    file_name: &'a str,
    line: u32,
    suggestion_applicability: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    why: Option<&'a str>,
}

/// A message for each fix: what became of those that can be made, and why the others cannot.
#[must_use]
pub fn fixes(revision: &Revision, outcome: FixOutcome) -> String {
    let mut text = String::new();
    for fix in &revision.made {
        push(&mut text, &message(fix, outcome, None));
    }
    for refused in &revision.refused {
        push(&mut text, &message(&refused.fix, FixOutcome::Refused, Some(&refused.why)));
    }
    text
}

fn message<'a>(fix: &'a Fix, outcome: FixOutcome, why: Option<&'a str>) -> FixMessage<'a> {
    FixMessage {
        reason: "ceid-fix",
        outcome,
        code: format!("ceid::{}", fix.rule),
        message: &fix.title,
        file_name: &fix.file,
        line: fix.line,
        suggestion_applicability: if fix.is_unsafe { "MaybeIncorrect" } else { "MachineApplicable" },
        why,
    }
}
