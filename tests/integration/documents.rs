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
fn archives_of_a_release_have_the_names_that_binstall_looks_for() {
    let metadata = cargo_metadata::MetadataCommand::new().current_dir(root()).no_deps().exec().expect("cargo answers");
    let package = metadata.packages.iter().find(|package| *package.name == "cargo-ceid-lint").expect("it is a member");
    let binstall = &package.metadata["binstall"];
    let template = |key: &str| binstall[key].as_str().expect("it is a text").replace("{ ", "{").replace(" }", "}");
    let as_in_the_script = |text: &str| {
        ["name", "target", "version"]
            .iter()
            .fold(text.to_owned(), |text, variable| text.replace(&format!("{{{variable}}}"), &format!("${variable}")))
    };
    let script = read(".ci/package");
    let folder = script.lines().find_map(|line| line.strip_prefix("folder=")).expect("the script names its folder");
    let url = as_in_the_script(&template("pkg-url"));
    assert_eq!(url, format!("{{repo}}/releases/download/v$version/{folder}{{archive-suffix}}"));
    assert_eq!(as_in_the_script(&template("bin-dir")), format!("{folder}/{{bin}}{{binary-ext}}"));
    assert!(script.contains(&format!("$folder.{}\"", template("pkg-fmt"))), "the archive is of another format");
    assert_holds(".github/workflows/release.yml", ".ci/package");
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

/// The arguments of every `cargo ceid-lint` that a document shows.
fn shown_commands(path: &str) -> Vec<Vec<String>> {
    let text = read(path);
    let commands =
        text.lines().filter_map(|line| line.trim_start_matches([' ', '-']).trim().strip_prefix("cargo ceid-lint"));
    let commands = commands.map(|args| args.split(" > ").next().unwrap_or(args));
    commands.map(|args| args.split_whitespace().map(str::to_owned).collect()).collect()
}

#[test]
fn commands_of_the_documents_are_understood() {
    let mut seen = 0;
    for path in ["README.md", "cargo-ceid-lint/docs/continuous-integration.md"] {
        for args in shown_commands(path) {
            let directory = workspace::temporary_package("documents", &[("src/lib.rs", workspace::GUILTY.as_bytes())]);
            let run = run(&directory, &args);
            assert!(matches!(run.code, Some(0 | 100)), "{path}: {args:?}\n{}", run.stderr);
            seen += 1;
        }
    }
    assert!(seen > 5, "{seen}");
}

#[test]
fn action_runs_what_the_page_shows() {
    let action = read(".github/actions/ceid-lint/action.yml");
    let flags = "--output github=- --output sarif=";
    assert!(action.contains(flags) && read("cargo-ceid-lint/docs/continuous-integration.md").contains(flags));
    let path = "cargo-ceid-lint";
    assert!(action.contains(&format!("/../../../{path}")) && root().join(path).join("Cargo.toml").is_file());
}
