//! The rules: their names, groups, default levels and texts, in one table. Never prints, and knows no format.

mod findings;
mod hygiene;
mod known;
mod levels;
mod missed;
mod remarks;
mod repeated;
mod skipped;

pub use findings::findings;
pub use hygiene::hygiene;
pub use known::Known;
pub use levels::{Setting, level_of, unknown_name, validate};

use crate::diagnostic::Level;

/// What a finding can be called.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// The name without the tool's prefix: `missed_update`.
    pub name: &'static str,
    /// The group it belongs to.
    pub group: Group,
    /// The level when nobody asks for another one.
    pub default_level: Level,
    /// What is wrong, in one sentence; lower case, no full stop.
    pub summary: &'static str,
    /// The long text, in Markdown.
    pub explanation: &'static str,
}

impl Rule {
    /// The name with the tool's prefix: `ceid::missed_update`.
    #[must_use]
    pub fn id(&self) -> String {
        format!("ceid::{}", self.name)
    }

    /// All that there is to say about it, in Markdown.
    #[must_use]
    pub fn page(&self) -> String {
        let (level, group) = (self.default_level.name(), self.group.name());
        format!("{}\nDefault level: `{level}`. Group: `ceid::{group}`.\n\n{ASSUMPTIONS}", self.explanation)
    }
}

/// Rules that are switched together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Group {
    /// Proved to be wrong.
    Correctness,
    /// Nearly always wrong.
    Suspicious,
    /// How the cycle deals with time.
    TimeDomain,
    /// What stands between the code and a complete proof.
    Proof,
    /// The suppressions themselves.
    Hygiene,
}

/// All groups, in the order of their weight.
pub const GROUPS: &[Group] = &[Group::Correctness, Group::Suspicious, Group::TimeDomain, Group::Proof, Group::Hygiene];

/// The group of all rules.
pub const ALL: &str = "all";

/// The rules that are at `warn`, as for rustc: `-D warnings`.
pub const WARNINGS: &str = "warnings";

impl Group {
    /// The name without the tool's prefix.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Correctness => "correctness",
            Self::Suspicious => "suspicious",
            Self::TimeDomain => "time_domain",
            Self::Proof => "proof",
            Self::Hygiene => "hygiene",
        }
    }

    /// The level of its rules when nobody asks for another one.
    #[must_use]
    pub const fn default_level(self) -> Level {
        match self {
            Self::Correctness => Level::Deny,
            Self::Suspicious | Self::Hygiene => Level::Warn,
            Self::TimeDomain | Self::Proof => Level::Allow,
        }
    }

    /// What its rules have in common; lower case, no full stop.
    #[must_use]
    pub fn summary(self) -> &'static str {
        match self {
            Self::Correctness => "proved to be wrong",
            Self::Suspicious => "wrong unless it was meant so",
            Self::TimeDomain => "how the cycle deals with time",
            Self::Proof => "what stands between the code and a complete proof",
            Self::Hygiene => "a suppression that suppresses nothing, or more than it says",
        }
    }
}

/// A rule at the level of its group, with the text of its file.
macro_rules! rule {
    ($name:literal, $group:ident, $summary:literal) => {
        Rule {
            name: $name,
            group: Group::$group,
            default_level: Group::$group.default_level(),
            summary: $summary,
            explanation: include_str!(concat!($name, ".md")),
        }
    };
}

/// All rules, sorted by name.
pub const RULES: &[Rule] = &[
    rule!("blanket_suppression", Hygiene, "a suppression that names no rule"),
    rule!("debug_only_update", Correctness, "a filter that stands still in a release build"),
    rule!("forgotten_guard", Correctness, "a guard whose destructor never runs updates nothing"),
    rule!("gated_update", Proof, "a filter that is updated only when a gate opens"),
    rule!("guard_dropped_early", Correctness, "a guard that ends before the cycle does"),
    rule!("guard_outside_cycle", Correctness, "a guard from before the loop updates once, not once per cycle"),
    rule!("missed_update", Correctness, "a filter that the cycle owes an update and never updates"),
    rule!("multi_event_update", Suspicious, "a filter with a fixed step that two different events advance"),
    rule!("rate_mismatch", TimeDomain, "a filter built for a step that is not the period of its cycle"),
    rule!("repeated_update", Correctness, "a filter that is updated twice or more in one cycle"),
    rule!("skipped_update", Suspicious, "a filter that some paths through the cycle do not update"),
    rule!("time_in_cycle", TimeDomain, "a cycle that waits, reads a clock or blocks by itself"),
    rule!("unguarded_update", Proof, "a filter that is updated once by attention, not by a guard"),
    rule!("unknown_rule", Hygiene, "a suppression of a rule that there is not, or of nearly the right form"),
    rule!("unproved_update", Proof, "a filter whose updates cannot be counted"),
    rule!("unregistered_filter", Suspicious, "a filter that is built and takes part in no cycle"),
    rule!("unused_suppression", Hygiene, "a suppression that suppresses nothing"),
];

/// What every proof rests on, in Markdown; `explain` prints it below each rule.
pub const ASSUMPTIONS: &str = include_str!("shared/assumptions.md");

/// The rule with this name, with or without the tool's prefix.
#[must_use]
pub fn find(name: &str) -> Option<&'static Rule> {
    let name = name.strip_prefix("ceid::").unwrap_or(name);
    RULES.iter().find(|rule| rule.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADINGS: [&str; 6] =
        ["What it does", "Why is this bad?", "What it cannot see", "Example", "Use instead", "References"];

    #[test]
    fn the_table_is_sorted_and_unique() {
        assert!(RULES.windows(2).all(|pair| pair[0].name < pair[1].name));
    }

    #[test]
    fn every_text_has_its_headings_in_order() {
        for rule in RULES {
            let headings: Vec<&str> = rule.explanation.lines().filter_map(|line| line.strip_prefix("## ")).collect();
            assert_eq!(headings, HEADINGS, "{}", rule.name);
            assert_eq!(rule.explanation.lines().next(), Some(format!("# `{}`", rule.id()).as_str()));
        }
    }

    #[test]
    fn every_text_is_listed() {
        let directory = concat!(env!("CARGO_MANIFEST_DIR"), "/src/rules");
        let mut names: Vec<String> = std::fs::read_dir(directory)
            .unwrap()
            .filter_map(|entry| Some(entry.unwrap().file_name().to_str()?.strip_suffix(".md")?.to_owned()))
            .collect();
        names.sort();
        assert_eq!(names, RULES.iter().map(|rule| rule.name).collect::<Vec<_>>());
    }

    #[test]
    fn groups_and_levels_agree() {
        for rule in RULES {
            assert!(GROUPS.contains(&rule.group));
            assert_eq!(rule.default_level, rule.group.default_level(), "{}", rule.name);
            assert!(find(rule.group.name()).is_none() && rule.name != ALL && rule.name != WARNINGS);
        }
    }

    #[test]
    fn every_text_has_two_whole_programs() {
        for rule in RULES {
            let blocks: Vec<&str> = rule.explanation.split("```rust\n").skip(1).collect();
            assert_eq!(blocks.len(), 2, "{}", rule.name);
            assert!(blocks.iter().all(|block| block.contains("\nfn main() {\n")), "{}", rule.name);
        }
    }

    #[test]
    fn summaries_are_half_sentences() {
        for rule in RULES {
            assert!(rule.summary.starts_with(char::is_lowercase) && !rule.summary.ends_with('.'), "{}", rule.name);
        }
    }
}
