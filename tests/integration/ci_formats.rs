//! The forms for services, by the whole program: valid against what the services publish, complete, and written where asked.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::support::program::{Run, program, run, run_command};
use crate::support::root;
use crate::support::workspace::{GUILTY, committed, temporary, temporary_package, write};

/// The published schema of SARIF 2.1.0, as OASIS has it at the address that is its `$id`.
fn sarif_schema() -> Value {
    let text = include_str!("../support/schemas/sarif-2.1.0.json");
    let mut schema: Value = serde_json::from_str(text).expect("a schema is JSON");
    // The published pattern for names of languages is no valid regular expression.
    for holder in ["run", "toolComponent"] {
        if let Some(language) = schema["definitions"][holder]["properties"]["language"].as_object_mut() {
            language.remove("pattern");
        }
    }
    schema
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}:\n{text}"))
}

/// The places where a finding of each kind comes from: witnesses over several files, fixes, suppressions, broken input.
fn checked_directories() -> Vec<PathBuf> {
    let suppressed =
        GUILTY.replace("    loop {", "    // ceid: allow(repeated_update, reason = \"two half steps\")\n    loop {");
    let guard = root().join("fixtures/rules/guard_dropped_early");
    let file = fs::read_to_string(guard.join("bound_to_an_underscore.rs")).expect("the case is there");
    vec![
        committed("figure3_legacy"),
        committed("two_crates"),
        committed("unparsable_file"),
        committed("missing_module"),
        temporary_package("ci_suppressed", &[("src/lib.rs", suppressed.as_bytes())]),
        temporary_package("ci_fix", &[("src/lib.rs", file.as_bytes())]),
        temporary_package(
            "ci_odd_name",
            &[("src/lib.rs", "#[path = \"a b#ü.rs\"] mod odd;".as_bytes()), ("src/a b#ü.rs", GUILTY.as_bytes())],
        ),
        committed("broken_manifest"),
    ]
}

#[test]
fn sarif_is_valid_and_complete() {
    let schema = jsonschema::validator_for(&sarif_schema()).expect("the schema is one");
    for directory in checked_directories() {
        let args = ["--message-format", "sarif", "-W", "all", "--workspace"];
        let run = run(&directory, args);
        let document = json(&run.stdout);
        let errors: Vec<String> =
            schema.iter_errors(&document).map(|error| format!("{}: {error}", error.instance_path())).collect();
        assert!(errors.is_empty(), "{}: {errors:#?}", directory.display());
        let results = document["runs"][0]["results"].as_array().expect("there is a list");
        let cargo_form = self::run(&directory, ["--message-format", "json", "-W", "all", "--workspace"]);
        let messages = cargo_form.stdout.lines().filter(|line| line.contains("\"$message_type\":\"diagnostic\""));
        let findings = messages.filter(|line| line.contains("\"ceid\":{")).count();
        assert_eq!(results.len(), findings, "{}", directory.display());
        assert_eq!(document["runs"][0]["invocations"][0]["exitCode"], run.code.expect("it ended by itself"));
        for result in results {
            check_result(result);
        }
    }
}

/// What code scanning needs beyond the schema.
#[track_caller]
fn check_result(result: &Value) {
    let location = &result["locations"][0]["physicalLocation"];
    assert_eq!(location["region"]["startLine"], location["region"]["endLine"], "{result}");
    let uri = location["artifactLocation"]["uri"].as_str().expect("a result has a file");
    assert!(!uri.starts_with('/') && !uri.contains([' ', '#', '\\']) && uri.is_ascii(), "{uri}");
    let hash = result["partialFingerprints"]["primaryLocationLineHash"].as_str().expect("a result has a hash");
    assert!(hash.split_once(':').is_some_and(|(hash, number)| !hash.is_empty() && number != "0"), "{hash}");
    for step in result.pointer("/codeFlows/0/threadFlows/0/locations").and_then(Value::as_array).into_iter().flatten() {
        assert!(step["location"]["message"]["text"].as_str().is_some_and(|text| !text.is_empty()), "{result}");
    }
}

#[test]
fn paths_are_those_of_the_repository() {
    let repository = temporary("ci_repository");
    fs::create_dir(repository.join(".git")).expect("the directory is empty");
    let manifest = b"[workspace]\n[package]\nname = \"arm\"\nversion = \"0.0.0\"\nedition = \"2024\"\n";
    write(&repository, "firmware/Cargo.toml", manifest);
    write(&repository, "firmware/src/lib.rs", GUILTY.as_bytes());
    let directory = repository.join("firmware");
    let sarif = json(&run(&directory, ["--message-format", "sarif"]).stdout);
    let uri = &sarif["runs"][0]["results"][0]["locations"][0]["physicalLocation"]["artifactLocation"]["uri"];
    assert_eq!(uri, "firmware/src/lib.rs");
    let gitlab = json(&run(&directory, ["--message-format", "gitlab"]).stdout);
    assert_eq!(gitlab[0]["location"]["path"], "firmware/src/lib.rs");
    let github = run(&directory, ["--message-format", "github"]).stdout;
    assert!(github.starts_with("::error file=firmware/src/lib.rs,line=7,endLine=7,col=9,"), "{github}");
}

#[test]
fn each_form_can_have_a_file_of_its_own_in_one_run() {
    let directory = temporary_package("ci_outputs", &[("src/lib.rs", GUILTY.as_bytes())]);
    let args = ["--output", "sarif=out/ceid.sarif", "--output", "junit=out/ceid.xml", "--output", "gitlab=ceid.json"];
    let run = run(&directory, args);
    run.assert_code(100).assert_stderr("error[ceid::repeated_update]");
    assert_eq!(run.stdout, "");
    let read = |name: &str| fs::read_to_string(directory.join(name)).expect("it was written");
    assert_eq!(json(&read("out/ceid.sarif"))["runs"][0]["results"].as_array().map(Vec::len), Some(1));
    assert_eq!(json(&read("ceid.json")).as_array().map(Vec::len), Some(1));
    assert_eq!(read("out/ceid.xml").matches("<failure").count(), 1);
}

#[test]
fn what_is_written_to_a_file_is_shown_to_people() {
    let directory = temporary_package("ci_output", &[("src/lib.rs", GUILTY.as_bytes())]);
    let run = run(&directory, ["--message-format", "sarif", "--output", "ceid.sarif"]);
    run.assert_code(100).assert_stderr("error[ceid::repeated_update]");
    assert_eq!(run.stdout, "");
    assert!(fs::read_to_string(directory.join("ceid.sarif")).is_ok_and(|text| text.starts_with('{')));
}

#[test]
fn a_file_that_cannot_be_written_is_named() {
    let directory = temporary_package("ci_unwritable", &[("src/lib.rs", b"")]);
    let run = run(&directory, ["--no-loops", "pass", "--output", "sarif=src/lib.rs/x.sarif"]);
    run.assert_code(101).assert_stderr("cannot write `src/lib.rs/x.sarif`: ");
    self::run(&directory, ["--output", "sarf=x"]).assert_code(2).assert_stderr("did you mean `sarif`?");
}

#[test]
fn a_run_that_cannot_be_made_is_not_a_clean_one() {
    let directory = temporary("ci_nothing");
    write(&directory, "Cargo.toml", b"[package\n");
    let sarif = run(&directory, ["--message-format", "sarif"]);
    let sarif = json(&sarif.assert_code(101).stdout);
    assert_eq!(sarif["runs"][0]["invocations"][0]["executionSuccessful"], false);
    let gitlab = json(&run(&directory, ["--message-format", "gitlab"]).assert_code(101).stdout);
    assert_eq!(gitlab[0]["severity"], "blocker");
    assert!(run(&directory, ["--message-format", "junit"]).assert_code(101).stdout.contains("<error"));
    assert!(run(&directory, ["--message-format", "github"]).assert_code(101).stdout.starts_with("::error file="));
}

#[test]
fn github_gets_annotations_and_a_table() {
    let directory = temporary_package("ci_github", &[("src/lib.rs", GUILTY.as_bytes())]);
    let summary = directory.join("summary.md");
    write(&directory, "summary.md", b"before\n");
    let run = run_in_action(&directory, &summary);
    assert_eq!(run.assert_code(100).stdout.matches("::error ").count(), 1);
    let text = fs::read_to_string(&summary).expect("it is there");
    assert!(text.starts_with("before\n") && text.matches("| `ceid::repeated_update` |").count() == 1, "{text}");
    run_in_action(&directory, &directory.join("src")).assert_code(101).assert_stderr("cannot write the step summary");
}

fn run_in_action(directory: &Path, summary: &Path) -> Run {
    // The variable that `run_command` takes away is set by `env`.
    let variable = format!("GITHUB_STEP_SUMMARY={}", summary.display());
    run_command(
        Command::new("env").arg(variable).arg(program()).args(["--message-format", "github"]).current_dir(directory),
    )
}

#[test]
fn parts_of_a_workspace_are_all_of_it() {
    let directory = temporary("ci_parts");
    write(&directory, "Cargo.toml", b"[workspace]\nresolver = \"3\"\nmembers = [\"axis*\"]\n");
    for axis in 0..5 {
        let manifest = format!("[package]\nname = \"axis{axis}\"\nversion = \"0.0.0\"\nedition = \"2024\"\n");
        write(&directory, &format!("axis{axis}/Cargo.toml"), manifest.as_bytes());
        write(&directory, &format!("axis{axis}/src/lib.rs"), GUILTY.as_bytes());
    }
    for kind in ["slice", "hash"] {
        let mut found = Vec::new();
        let mut categories = BTreeSet::new();
        for part in 1..=3 {
            let partition = format!("{kind}:{part}/3");
            let run = run(&directory, ["--partition", &partition, "--message-format", "sarif"]);
            let document = json(&run.stdout);
            categories.insert(document["runs"][0]["automationDetails"]["id"].to_string());
            let results = document["runs"][0]["results"].as_array().expect("there is a list").clone();
            let uri =
                |result: &Value| result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"].to_string();
            found.extend(results.iter().map(uri));
        }
        assert_eq!(found.len(), 5, "{kind}");
        assert_eq!(found.iter().collect::<BTreeSet<_>>().len(), 5, "{kind}");
        assert_eq!(categories.len(), 3, "{kind}");
    }
    let run = run(&directory, ["--partition", "slice:9/9", "--no-loops", "fail"]);
    run.assert_code(0).assert_stderr("this part of the workspace holds no package");
    self::run(&directory, ["--partition", "slice:4/3"]).assert_code(2).assert_stderr("there is no part 4 of 3");
}
