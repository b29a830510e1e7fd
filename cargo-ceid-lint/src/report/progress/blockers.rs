//! What stands in the way of the cycles that are not proved, the most frequent first.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use super::Standing;
use crate::count::{Pair, Verdict, is_guard_rule};
use crate::pipeline::Report;
use crate::source::Span;

/// A reason why filters are not proved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Blocker {
    /// A rule, `ceid::missed_update`, or a cause with what it names left out: "`…` gets it and its source cannot be seen".
    pub what: String,
    /// Whether it is a rule.
    pub is_rule: bool,
    /// How many filters it keeps from being proved.
    pub filters: usize,
    /// In how many cycles.
    pub cycles: usize,
    /// What the cause names, each once, sorted.
    pub names: BTreeSet<String>,
    /// The heads of the cycles, in the order of the report.
    pub places: Vec<Span>,
}

/// All reasons, the most frequent first.
#[must_use]
pub fn blockers(report: &Report) -> Vec<Blocker> {
    let mut found: BTreeMap<(bool, String), Blocker> = BTreeMap::new();
    for cycle in &report.cycles {
        for pair in cycle.filters.iter().filter(|pair| Standing::of_pair(pair) < Standing::Proved) {
            for (what, is_rule, names) in reasons(pair) {
                let blocker = found.entry((is_rule, what.clone())).or_insert_with(|| Blocker {
                    what,
                    is_rule,
                    filters: 0,
                    cycles: 0,
                    names: BTreeSet::new(),
                    places: Vec::new(),
                });
                blocker.filters += 1;
                blocker.names.extend(names);
                if blocker.places.last() != Some(&cycle.head) {
                    blocker.cycles += 1;
                    blocker.places.push(cycle.head);
                }
            }
        }
    }
    let mut blockers: Vec<Blocker> = found.into_values().collect();
    // The sort is stable, so that what is as frequent stays in the order of its words.
    blockers.sort_by_key(|blocker| Reverse((blocker.filters, blocker.cycles)));
    blockers
}

/// The rules that fire on a filter that is wrong, or the cause why it is not decided.
fn reasons(pair: &Pair) -> Vec<(String, bool, Vec<String>)> {
    if pair.verdict == Verdict::Unproved {
        let (what, names) = without_names(pair.cause.as_deref().unwrap_or("the cause is not known"));
        return vec![(what, false, names)];
    }
    // By its counts nothing is wrong where it is the guard that is.
    let of_guard = pair.rules.iter().copied().filter(|rule| is_guard_rule(rule));
    let rules = pair.verdict.rule().into_iter().chain(of_guard);
    rules.map(|rule| (format!("ceid::{rule}"), true, Vec::new())).collect()
}

/// A cause without what it names between backticks, and that.
fn without_names(cause: &str) -> (String, Vec<String>) {
    let mut names = Vec::new();
    let mut what = String::new();
    for (number, part) in cause.split('`').enumerate() {
        if number % 2 == 0 {
            what += part;
            continue;
        }
        names.push(part.to_owned());
        // What every name of its kind ends with says which kind it is.
        what += if part.ends_with('!') { "`…!`" } else { "`…`" };
    }
    (what, names)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;

    #[test]
    fn reasons_are_counted_over_all_cycles() {
        let (_, report) = sample::report();
        let found = blockers(&report);
        let shown: Vec<_> = found.iter().map(|it| (it.what.as_str(), it.filters, it.cycles)).collect();
        let expected = [
            ("the call of `…` cannot be followed", 1, 1),
            ("ceid::repeated_update", 1, 1),
            ("ceid::skipped_update", 1, 1),
        ];
        assert_eq!(shown, expected);
        assert!(found[0].names.contains("hook"));
    }

    #[test]
    fn a_cause_is_told_without_its_names() {
        assert_eq!(without_names("the macro `log!` mentions `kf`").0, "the macro `…!` mentions `…`");
        assert_eq!(without_names("nothing"), ("nothing".to_owned(), Vec::new()));
        assert_eq!(without_names("odd `x").0, "odd `…`");
    }
}
