//! The list of known findings: what it holds, what it hides, and what changes it.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::support::program::{Run, run};
use crate::support::workspace::{copy, temporary, temporary_package, write};

const FILE: &str = "ceid-baseline.toml";
const CONTROL: &str = "flight/src/control.rs";

/// A copy of the legacy drone.
fn drone(name: &str) -> PathBuf {
    copy("legacy_drone", name)
}

/// The same with its baseline.
fn known_drone(name: &str) -> PathBuf {
    let directory = drone(name);
    run(&directory, ["baseline"]).assert_code(0).assert_stderr("wrote `ceid-baseline.toml` with 8 findings");
    directory
}

fn baseline(directory: &Path) -> String {
    fs::read_to_string(directory.join(FILE)).expect("there is a baseline")
}

/// Replaces a text in a file, once.
#[track_caller]
fn change(directory: &Path, file: &str, old: &str, new: &str) {
    let text = fs::read_to_string(directory.join(file)).expect("the file is there");
    assert!(text.contains(old), "{file} does not hold `{old}`");
    write(directory, file, text.replacen(old, new, 1).as_bytes());
}

fn check(directory: &Path, args: &[&str]) -> Run {
    let run = run(directory, args);
    run.assert_no_panic();
    run
}

#[test]
fn what_is_known_fails_nothing_and_is_one_line() {
    let directory = drone("baseline_known");
    check(&directory, &[]).assert_code(100);
    run(&directory, ["baseline"]).assert_code(0);
    let clean = check(&directory, &["-D", "warnings"]);
    clean.assert_code(0).assert_stderr("8 known findings are in `ceid-baseline.toml`\n");
    assert_eq!(clean.stderr.lines().count(), 2, "{}", clean.stderr);
    check(&directory, &["--no-baseline"]).assert_code(100).assert_stderr("error[ceid::repeated_update]");
    run(&directory, ["baseline"]).assert_code(0).assert_stderr("is up to date");
}

#[test]
fn functions_of_one_name_are_told_apart() {
    let directory = known_drone("baseline_names");
    let text = baseline(&directory);
    let functions = [
        "<Hover as Task>::run",
        "<Land as Task>::run",
        "Climb::run",
        "Climb<f64>::run_short",
        "return_home::run",
        "\"run\"",
    ];
    for function in functions {
        assert!(text.contains(function), "{function} is not in\n{text}");
    }
    // One of them is not known for the other one's sake.
    let update = "            self.height.update();\n";
    change(
        &directory,
        CONTROL,
        &format!("run_short(&mut self) {{\n        loop {{\n{update}"),
        &format!("run_short(&mut self) {{\n        loop {{\n{update}{update}"),
    );
    check(&directory, &["--message-format", "short"]).assert_code(100).assert_stderr("repeated_update");
}

#[test]
fn lines_order_and_loops_that_are_right_do_not_matter() {
    let directory = known_drone("baseline_moves");
    let text = fs::read_to_string(directory.join(CONTROL)).expect("the file is there");
    let (head, land) = text.split_once("#[derive(Default)]\npub struct Land").expect("it is there");
    let (land, rest) = land.split_once("pub struct Climb").expect("it is there");
    let right = "    pub fn calm(&mut self) {\n        loop {\n            self.height.update();\n        }\n    }\n";
    let rest = rest.replacen(
        "    pub fn run(&mut self) {",
        &format!("{right}\n    pub fn run(&mut self) {{ let _pause = 1;"),
        1,
    );
    let rest = rest.replace("gps", "receiver").replace("T: Copy", "Value: Copy").replace("<T>", "<Value>");
    let rest = rest.replace("Height<T>", "Height<Value>");
    let head = head.replacen("use crate", "// A comment.\n\n\nuse crate", 1);
    let moved = format!("{head}pub struct Climb{rest}\n#[derive(Default)]\npub struct Land{land}");
    write(&directory, CONTROL, moved.as_bytes());
    let before = baseline(&directory);
    check(&directory, &["-D", "warnings"]).assert_code(0).assert_stderr("8 known findings");
    run(&directory, ["baseline", "--prune", "--accept-new"]).assert_code(0);
    assert_eq!(baseline(&directory), before);
}

#[test]
fn what_is_new_fails_and_is_taken_in_only_when_asked() {
    let directory = known_drone("baseline_new");
    let new = "pub fn turn(mut yaw: Attitude) {\n    loop {\n        yaw.update();\n        yaw.update();\n    }\n}\n";
    let text = fs::read_to_string(directory.join(CONTROL)).expect("the file is there");
    write(&directory, CONTROL, format!("{text}\n{new}").as_bytes());
    let found = check(&directory, &["--message-format", "json"]).assert_code(100).findings().expect("a whole run");
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].message.contains("`yaw`"), "{found:?}");
    let before = baseline(&directory);
    let refused = check(&directory, &["baseline"]);
    refused.assert_code(100).assert_stderr("1 finding is not in `ceid-baseline.toml`").assert_stderr("--accept-new");
    check(&directory, &["baseline", "--prune"]).assert_code(100);
    assert_eq!(baseline(&directory), before);
    check(&directory, &["baseline", "--accept-new"]).assert_code(0).assert_stderr("added 1 finding");
    check(&directory, &[]).assert_code(0).assert_stderr("9 known findings");
    let after = baseline(&directory);
    let added: Vec<&str> = after.lines().filter(|line| !before.contains(line)).collect();
    assert_eq!(added.len(), 1, "{added:?}");
}

#[test]
fn what_is_fixed_is_told_and_taken_out_only_when_asked() {
    let directory = known_drone("baseline_fixed");
    change(
        &directory,
        "ground/src/main.rs",
        "        signal.update();\n        signal.update();\n",
        "        signal.update();\n",
    );
    let stale =
        "1 finding of `ceid-baseline.toml` is no longer reported: `cargo ceid-lint baseline --prune` takes it out";
    check(&directory, &["-D", "warnings"]).assert_code(0).assert_stderr(stale).assert_stderr("7 known findings");
    check(&directory, &["baseline"]).assert_code(0).assert_stderr(stale);
    check(&directory, &["baseline", "--accept-new"]).assert_code(0).assert_stderr(stale);
    assert!(baseline(&directory).contains("signal"));
    check(&directory, &["baseline", "--prune"]).assert_code(0).assert_stderr("took out 1 finding");
    assert!(!baseline(&directory).contains("signal"));
    let clean = check(&directory, &[]);
    assert!(!clean.stderr.contains("no longer reported"), "{}", clean.stderr);
    // Nor does what was fixed come back unseen.
    change(
        &directory,
        "ground/src/main.rs",
        "        signal.update();\n",
        "        signal.update();\n        signal.update();\n",
    );
    check(&directory, &[]).assert_code(100);
}

#[test]
fn where_there_is_more_than_is_known_all_of_it_is_shown() {
    let directory = known_drone("baseline_more");
    let twice = "        loop {\n            self.height.update();\n            self.height.update();\n        }\n";
    let or_twice = format!("        if core::mem::size_of::<T>() > 4 {{\n{twice}        }}\n{twice}");
    change(&directory, CONTROL, twice, &or_twice);
    let more = check(&directory, &[]);
    more.assert_code(100).assert_stderr("7 known findings");
    let note =
        "there are 2 such findings on `self.height` in this function, and `ceid-baseline.toml` knows 1: all are shown";
    assert_eq!(more.stderr.matches(note).count(), 2, "{}", more.stderr);
}

#[test]
fn a_part_of_the_code_says_nothing_of_the_rest() {
    let directory = known_drone("baseline_parts");
    let before = baseline(&directory);
    for args in [
        &["-p", "ground"][..],
        &["-p", "flight"],
        &["ground/src"],
        &["flight/src/filters.rs"],
        &["--partition", "slice:2/2"],
        &["--bins"],
        &["-A", "repeated_update"],
    ] {
        let part = check(&directory, args);
        assert!(!part.stderr.contains("no longer reported"), "{args:?}\n{}", part.stderr);
        let args: Vec<&str> = [&["baseline", "--prune"], args].concat();
        check(&directory, &args).assert_code(0);
        assert_eq!(baseline(&directory), before, "{args:?}");
    }
    // What is fixed in the part is told all the same.
    change(&directory, "ground/src/main.rs", "        signal.update();\n", "");
    check(&directory, &["-p", "ground"]).assert_code(0).assert_stderr("1 finding of");
    check(&directory, &["ground/src/main.rs"]).assert_stderr("1 finding of");
    let other = check(&directory, &["-p", "flight"]);
    assert!(!other.stderr.contains("no longer reported"), "{}", other.stderr);
    // Neither is anything fixed that cannot be read.
    write(&directory, "ground/src/main.rs", b"fn main( {");
    let broken = check(&directory, &["baseline", "--prune"]);
    broken.assert_code(101).assert_stderr("nothing is taken out");
    assert_eq!(baseline(&directory), before);
}

#[test]
fn other_features_are_another_part() {
    let directory = drone("baseline_features");
    run(&directory, ["baseline", "--all-features"]).assert_code(0).assert_stderr("with 9 findings");
    let before = baseline(&directory);
    let plain = check(&directory, &[]);
    assert!(!plain.stderr.contains("no longer reported"), "{}", plain.stderr);
    check(&directory, &["baseline", "--prune"]).assert_code(0);
    assert_eq!(baseline(&directory), before);
    // So are conditions inside a file and inside a function.
    change(&directory, CONTROL, "pub mod return_home", "#[cfg(feature = \"gimbal\")]\npub mod return_home");
    change(
        &directory,
        CONTROL,
        "            attitude.update();\n            attitude.update();\n        }\n    };",
        "            attitude.update();\n            #[cfg(feature = \"gimbal\")]\n            attitude.update();\n        }\n    };",
    );
    let plain = check(&directory, &[]);
    assert!(!plain.stderr.contains("no longer reported"), "{}", plain.stderr);
    check(&directory, &["--all-features"]).assert_code(0).assert_stderr("9 known findings");
}

#[test]
fn a_file_that_is_gone_takes_its_findings_with_it() {
    let directory = drone("baseline_gone");
    run(&directory, ["baseline", "--all-features"]).assert_code(0);
    fs::remove_file(directory.join("flight/src/gimbal.rs")).expect("it is there");
    change(&directory, "flight/src/lib.rs", "#[cfg(feature = \"gimbal\")]\npub mod gimbal;\n", "");
    let other = check(&directory, &["-p", "ground"]);
    assert!(!other.stderr.contains("no longer reported"), "{}", other.stderr);
    check(&directory, &[]).assert_code(0).assert_stderr("1 finding of `ceid-baseline.toml` is no longer reported");
    check(&directory, &["baseline", "--prune"]).assert_code(0);
    assert!(!baseline(&directory).contains("gimbal"));
}

#[test]
fn findings_outside_of_functions_are_counted_too() {
    let text = "// ceid: allow(missed_update, reason = \"none\")\npub struct Empty;\n";
    let directory = temporary_package("baseline_outside", &[("src/lib.rs", text.as_bytes())]);
    run(&directory, ["--no-loops", "pass", "-D", "warnings"]).assert_code(100);
    run(&directory, ["baseline", "--no-loops", "pass"]).assert_code(0);
    let entry = "{ file = \"src/lib.rs\", rule = \"unused_suppression\", count = 1 }";
    assert!(baseline(&directory).contains(entry), "{}", baseline(&directory));
    run(&directory, ["--no-loops", "pass", "-D", "warnings"]).assert_code(0).assert_stderr("1 known finding is in");
}

#[test]
fn a_baseline_that_is_named_has_to_be_there() {
    let directory = drone("baseline_named");
    let missing = check(&directory, &["--baseline", "debts.toml"]);
    missing.assert_code(101).assert_stderr("debts.toml").assert_stderr("no such file");
    check(&directory, &["report", "--baseline", "debts.toml"]).assert_code(101);
    check(&directory, &["baseline", "--prune"]).assert_code(101).assert_stderr("there is no baseline");
    check(&directory, &["baseline", "--baseline", "debts.toml"]).assert_code(0).assert_stderr("wrote `debts.toml`");
    assert!(!directory.join(FILE).exists());
    check(&directory, &["--baseline", "debts.toml"])
        .assert_code(0)
        .assert_stderr("8 known findings are in `debts.toml`");
    check(&directory, &[]).assert_code(100);
    check(&directory, &["--baseline", "debts.toml", "--no-baseline"]).assert_code(2);
    // The paths in it are those from the root, wherever the program runs.
    let below = directory.join("flight");
    check(&below, &["--baseline", "../debts.toml", "--workspace"]).assert_code(0).assert_stderr("8 known findings");
}

#[test]
fn a_malformed_baseline_is_an_error_with_its_place() {
    let directory = known_drone("baseline_malformed");
    let good = baseline(&directory);
    for (old, new, message, help) in [
        (
            "rule = \"repeated_update\"",
            "rule = \"repaeted_update\"",
            "unknown rule `repaeted_update`",
            "did you mean `repeated_update`?",
        ),
        ("version", "vresion", "unknown key `vresion`", "did you mean `version`?"),
        ("count = 1", "count = \"1\"", "expected an integer", ""),
        ("known = [", "<<<<<<< HEAD\nknown = [", "ceid-baseline.toml:5", ""),
    ] {
        write(&directory, FILE, good.replacen(old, new, 1).as_bytes());
        for args in [&[][..], &["report"], &["baseline"]] {
            check(&directory, args).assert_code(101).assert_stderr(message).assert_stderr(help);
        }
        assert_eq!(baseline(&directory), good.replacen(old, new, 1));
    }
    write(&directory, FILE, good.replacen("version = 1", "version = 2", 1).as_bytes());
    let json = check(&directory, &["--message-format", "json"]);
    assert!(json.assert_code(101).stdout.contains("\"file_name\":\"ceid-baseline.toml\""), "{}", json.stdout);
}

#[test]
fn a_file_that_cannot_be_written_is_left_as_it_is() {
    let directory = known_drone("baseline_readonly");
    let path = directory.join(FILE);
    let before = baseline(&directory);
    let mut permissions = fs::metadata(&path).expect("it is there").permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&path, permissions).expect("it is ours");
    change(&directory, "ground/src/main.rs", "        signal.update();\n", "");
    check(&directory, &["baseline", "--prune"]).assert_code(101).assert_stderr("read-only");
    assert_eq!(baseline(&directory), before);
    let left = fs::read_dir(&directory).expect("it is there").filter_map(Result::ok);
    assert!(!left.into_iter().any(|entry| entry.file_name().to_string_lossy().contains(".tmp")));
}

#[test]
fn programs_see_what_is_known_and_editors_do_not() {
    let directory = known_drone("baseline_formats");
    let json = check(&directory, &["--message-format", "json"]);
    assert_eq!(json.findings(), Ok(Vec::new()));
    let lines = json.stdout.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let messages: Vec<Value> = lines.filter(|line| line["reason"] == "compiler-message").collect();
    assert_eq!(messages.len(), 8);
    for message in messages.iter().map(|line| &line["message"]) {
        assert_eq!((&message["ceid"]["known"], &message["rendered"]), (&Value::Bool(true), &Value::Null));
        let spans = message["spans"].as_array().expect("there is a list");
        assert!(spans.iter().all(|span| span["is_primary"] == false), "{message}");
    }
    let sarif = |directory: &Path| -> Vec<Value> {
        let run = check(directory, &["--message-format", "sarif"]);
        let document: Value = serde_json::from_str(&run.stdout).expect("SARIF is JSON");
        document["runs"][0]["results"].as_array().expect("there is a list").clone()
    };
    let results = sarif(&directory);
    assert!(results.iter().all(|it| it["baselineState"] == "unchanged" && it["suppressions"][0]["kind"] == "external"));
    let prints: Vec<Value> = results.iter().map(|it| it["partialFingerprints"].clone()).collect();
    for format in ["github", "gitlab", "short"] {
        let printed = check(&directory, &["--message-format", format]);
        assert!(!printed.stdout.contains("repeated_update") && !printed.stderr.contains("repeated_update"), "{format}");
    }
    let junit = check(&directory, &["--message-format", "junit"]).stdout;
    assert!(junit.contains("repeated, which is known") && !junit.contains("<failure"), "{junit}");
    let report: Value =
        serde_json::from_str(&check(&directory, &["report", "--message-format", "json"]).stdout).expect("it is JSON");
    assert_eq!(report["cycles"][0]["filters"][0]["known"], true);
    fs::remove_file(directory.join(FILE)).expect("it is there");
    let results = sarif(&directory);
    assert!(results.iter().all(|it| it["baselineState"].is_null() && it["suppressions"] == Value::Array(Vec::new())));
    let without: Vec<Value> = results.iter().map(|it| it["partialFingerprints"].clone()).collect();
    assert_eq!(prints, without, "a service takes what it does not find again for fixed");
}

#[test]
fn what_is_forbidden_is_never_known() {
    let directory = drone("baseline_forbidden");
    let args = ["baseline", "--forbid", "repeated_update"];
    check(&directory, &args).assert_code(0).assert_stderr("7 findings of forbidden rules are left out");
    check(&directory, &["--forbid", "repeated_update"]).assert_code(100).assert_stderr("1 known finding is");
}

#[test]
fn suppressed_findings_are_not_counted() {
    let directory = known_drone("baseline_suppressed");
    let before = "        loop {\n            self.height.update();\n            self.height.update();";
    let after =
        before.replacen("loop", "// ceid: allow(repeated_update, reason = \"two half steps\")\n        loop", 1);
    change(&directory, CONTROL, before, &after);
    check(&directory, &["-D", "warnings"])
        .assert_code(0)
        .assert_stderr("1 finding of `ceid-baseline.toml` is no longer reported");
}

#[test]
fn each_workspace_has_a_baseline_of_its_own() {
    let directory = temporary("baseline_workspaces");
    for name in ["one", "two"] {
        let manifest = format!("[workspace]\n[package]\nname = \"{name}\"\nversion = \"0.0.0\"\nedition = \"2024\"\n");
        write(&directory, &format!("{name}/Cargo.toml"), manifest.as_bytes());
        write(&directory, &format!("{name}/src/lib.rs"), crate::support::workspace::GUILTY.as_bytes());
    }
    run(&directory, ["baseline", "one", "two"]).assert_code(0);
    for name in ["one", "two"] {
        let text = fs::read_to_string(directory.join(name).join(FILE)).expect("it was written");
        assert!(text.contains("file = \"src/lib.rs\""), "{text}");
    }
    run(&directory, ["one", "two"]).assert_code(0).assert_stderr("1 known finding is in");
}
