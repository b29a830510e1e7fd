//! Under which names a finding is counted.

use std::collections::BTreeMap;

use crate::diagnostic::Diagnostic;

/// What is counted.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// The file of the cycle, or of the place where there is none, from the root of the workspace, with `/`.
    pub file: String,
    /// The function in it: see [`FunctionPlace::path`](crate::index::FunctionPlace); empty outside of all functions.
    pub function: String,
    /// The name of the rule without prefix.
    pub rule: &'static str,
    /// The filter as the source spells it; empty if the finding is about none.
    pub filter: String,
}

/// How many findings there are of each.
pub type Counts = BTreeMap<Key, u32>;

/// The names under which a finding is counted: one for each of its filters, however they are put together in one message.
#[must_use]
pub fn keys(finding: &Diagnostic, file: &str, function: &str) -> Vec<Key> {
    let key = |rule: &'static str, filter: &str| Key {
        file: file.to_owned(),
        function: function.to_owned(),
        rule,
        filter: filter.to_owned(),
    };
    let filters = &finding.facts.filters;
    let Some((first, others)) = filters.split_first() else { return vec![key(finding.rule, "")] };
    // Beside a repetition stand the siblings that it was pasted from: they are told by themselves once it is gone.
    let of_others = if finding.rule == "repeated_update" { "missed_update" } else { finding.rule };
    let mut keys = vec![key(finding.rule, first)];
    keys.extend(others.iter().map(|filter| key(of_others, filter)));
    keys.dedup();
    keys
}
