//! What is told of a loop that gets a guard.

use super::told;
use crate::migrate::{Plan, Rewrite};
use crate::pipeline::Report;

/// What a person should know of a rewriting, and what it changes.
pub(super) struct Offered {
    pub(super) notes: Vec<String>,
    pub(super) changes: Vec<String>,
}

impl Offered {
    pub(super) fn of(report: &Report, plan: &Plan, rewrite: &Rewrite) -> Self {
        let mut changes: Vec<String> = rewrite.changes.iter().map(|change| told(report, plan, change)).collect();
        // Two calls in a line may have the same.
        changes.dedup();
        Self { notes: rewrite.notes.clone(), changes }
    }

    /// The same with the lines of the text that was there before other loops were rewritten, where the same was told of that.
    pub(super) fn in_lines_of(self, first: Option<Self>) -> Self {
        let Some(first) = first else { return self };
        Self { notes: earlier(self.notes, first.notes), changes: earlier(self.changes, first.changes) }
    }
}

fn earlier(now: Vec<String>, first: Vec<String>) -> Vec<String> {
    let without_lines = |told: &String| told.replace(|sign: char| sign.is_ascii_digit(), "");
    if now.iter().map(without_lines).eq(first.iter().map(without_lines)) { first } else { now }
}
