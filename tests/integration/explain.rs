//! The examples in the text of each rule: the bad one gives exactly that rule, the good one nothing.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::support::program::{Finding, run};
use crate::support::{RULES, root, workspace};

fn texts() -> Vec<(String, String)> {
    let directory = root().join("cargo-ceid-lint/src/rules");
    let mut paths: Vec<PathBuf> = std::fs::read_dir(directory)
        .expect("the rules are there")
        .map(|entry| entry.expect("readable").path())
        .collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "md"));
    paths.sort();
    let read = |path: &PathBuf| {
        let name = path.file_stem().expect("it has a name").to_string_lossy().into_owned();
        (name, std::fs::read_to_string(path).expect("the text is readable"))
    };
    paths.iter().map(read).collect()
}

/// The first Rust block after the heading or the line that starts with `title`.
fn block<'a>(text: &'a str, title: &str) -> Option<&'a str> {
    let mut offset = 0;
    for line in text.lines() {
        if line.trim_start_matches(['#', '*', ' ']).starts_with(title) {
            let rest = &text[offset..];
            let start = rest.find("```rust")?;
            let body = &rest[start..][rest[start..].find('\n')? + 1..];
            return body.find("```").map(|end| &body[..end]);
        }
        offset += line.len() + 1;
    }
    None
}

/// Checks a block as a file of its own, with the rule switched on.
fn findings(rule: &str, kind: &str, code: &str, directory: &Path) -> Vec<Finding> {
    let file = format!("{rule}_{kind}.rs");
    workspace::write(directory, &file, code.as_bytes());
    let run = run(directory, ["--message-format", "json", "-W", rule, &file]);
    run.findings().unwrap_or_else(|error| panic!("{rule}: {error}"))
}

#[test]
fn every_rule_has_a_text() {
    let names: Vec<String> = texts().into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, RULES);
}

#[test]
fn examples_show_their_rule_and_nothing_else() {
    let directory = workspace::temporary("explain");
    let mut failures = String::new();
    for (rule, text) in texts() {
        let (Some(bad), Some(good)) = (block(&text, "Example"), block(&text, "Use instead")) else {
            failures += &format!("{rule}: no `Example` and `Use instead` blocks\n");
            continue;
        };
        let bad = findings(&rule, "bad", bad, &directory);
        let rules: BTreeSet<&str> = bad.iter().map(|finding| finding.rule.as_str()).collect();
        if rules != BTreeSet::from([rule.as_str()]) {
            failures += &format!("{rule}: the example gives {rules:?}\n");
        }
        for finding in findings(&rule, "good", good, &directory) {
            failures += &format!("{rule}: the cure gives {} on line {}\n", finding.rule, finding.line);
        }
    }
    assert!(failures.is_empty(), "{failures}");
}

#[test]
fn explain_prints_the_text() {
    for (rule, text) in texts() {
        let run = run(&root(), ["explain", &rule]);
        let first = text.lines().find(|line| !line.is_empty() && !line.starts_with('#')).unwrap_or_default();
        assert!(run.assert_code(0).stdout.contains(first), "{rule}:\n{}", run.stdout);
    }
}

#[test]
fn unknown_rule_is_told_with_a_correction() {
    run(&root(), ["explain", "mised_update"]).assert_code(2).assert_stderr("missed_update");
}
