//! What the documents say is what the program does.

use std::fmt::Write as _;

use cargo_ceid_lint::rules;

use crate::support::program::run;
use crate::support::{root, workspace};

fn read(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Asserts that a document holds a text, which is shown whole so that it can be pasted.
#[track_caller]
fn assert_holds(path: &str, text: &str) {
    assert!(read(path).contains(text), "{path} does not hold this text:\n\n{text}\n");
}

#[test]
fn readme_lists_every_rule() {
    let mut table = "| rule | finds | level |\n| --- | --- | --- |\n".to_owned();
    for rule in rules::RULES {
        writeln!(table, "| `{}` | {} | {} |", rule.name, rule.summary, rule.default_level.name()).expect("a String");
    }
    table.push('\n');
    assert_holds("README.md", &table);
}

#[test]
fn readme_shows_what_the_program_prints() {
    let run = run(&workspace::committed("figure3_legacy"), [""; 0]);
    assert_holds("README.md", &format!("```text\n{}```\n", run.assert_code(100).stderr));
}

#[test]
fn readme_shows_the_proof_report() {
    let run = run(&workspace::committed("figure3_legacy"), ["report"]);
    assert_holds("README.md", &format!("```text\n{}```\n", run.assert_code(0).stdout));
}

#[test]
fn continuous_integration_runs_the_test_command_of_the_readme() {
    let readme = read("README.md");
    let command = readme.lines().find(|line| line.starts_with("cargo test")).expect("the README says how to test");
    assert!(read(".ci/run").lines().any(|line| line.trim().ends_with(command)), ".ci/run does not run `{command}`");
    assert_holds(".github/workflows/ci.yml", ".ci/run");
}

#[test]
fn example_of_the_readme_is_there() {
    assert_holds("README.md", "cargo run -- --manifest-path fixtures/workspaces/figure3_legacy/Cargo.toml\n");
}

#[test]
fn every_rule_has_cases() {
    for rule in rules::RULES {
        let directory = root().join("fixtures/rules").join(rule.name);
        let cases = std::fs::read_dir(&directory).map_or(0, Iterator::count);
        assert!(cases > 0, "fixtures/rules/{} has no case", rule.name);
    }
}

#[test]
fn every_exit_code_is_documented() {
    for path in ["README.md", "cargo-ceid-lint/src/cli/args.rs", "cargo-ceid-lint/src/cli/exit.rs"] {
        for code in ["0", "2", "100", "101"] {
            assert!(
                read(path).split(|letter: char| !letter.is_ascii_digit()).any(|word| word == code),
                "{path} does not name the exit code {code}"
            );
        }
    }
}
