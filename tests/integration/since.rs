//! `--since`: only what touches lines that were changed since a git revision.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use cargo_metadata::Message;
use cargo_metadata::diagnostic::DiagnosticLevel;

use crate::support::program::{Finding, run};
use crate::support::workspace::{GUILTY, temporary, temporary_package, write};

/// A filter, and a function for each name that updates it twice.
fn guilty(names: &[&str]) -> String {
    let head = "pub trait SampledFilter { fn update(&mut self); }\npub struct Kalman;\nimpl SampledFilter for Kalman { fn update(&mut self) {} }\n";
    let function = |name: &&str| {
        format!(
            "\npub fn {name}(mut kf: Kalman) {{\n    loop {{\n        kf.update();\n        kf.update();\n    }}\n}}\n"
        )
    };
    head.to_owned() + &names.iter().map(function).collect::<String>()
}

#[track_caller]
fn git(directory: &Path, args: &[&str]) {
    let identity = ["-c", "user.name=Ada", "-c", "user.email=ada@example.com", "-c", "commit.gpgsign=false"];
    let output =
        Command::new("git").args(identity).args(args).current_dir(directory).output().expect("git is installed");
    assert!(output.status.success(), "git {args:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// A repository with one commit, whose package lies in a directory of it.
fn repository(name: &str, files: &[(&str, &str)]) -> PathBuf {
    let directory = temporary(name);
    let manifest = format!("[workspace]\n[package]\nname = \"{name}\"\nversion = \"0.0.0\"\nedition = \"2024\"\n");
    write(&directory, "firm ware/Cargo.toml", manifest.as_bytes());
    for (path, text) in files {
        write(&directory, &format!("firm ware/{path}"), text.as_bytes());
    }
    git(&directory, &["init", "--quiet", "--initial-branch=main"]);
    // What a person has set must not change what is read.
    for (key, value) in
        [("diff.noprefix", "true"), ("color.ui", "always"), ("diff.external", "false"), ("diff.mnemonicPrefix", "true")]
    {
        git(&directory, &["config", key, value]);
    }
    git(&directory, &["add", "."]);
    git(&directory, &["commit", "--quiet", "-m", "before"]);
    directory.join("firm ware")
}

#[track_caller]
fn found(directory: &Path, args: &[&str]) -> Vec<Finding> {
    let run = run(directory, [&["--message-format", "json"], args].concat());
    run.assert_no_panic();
    run.findings().unwrap_or_else(|error| panic!("{error}\n{}", run.stderr))
}

fn change(directory: &Path, file: &str, old: &str, new: &str) {
    let text = fs::read_to_string(directory.join(file)).expect("the file is there");
    assert!(text.contains(old), "{file} does not hold `{old}`");
    write(directory, file, text.replacen(old, new, 1).as_bytes());
}

#[test]
fn what_touches_no_changed_line_is_left_out() {
    let directory = repository("since_lines", &[("src/lib.rs", &guilty(&["climb", "land"]))]);
    let run_all = run(&directory, ["--since", "HEAD"]);
    run_all.assert_code(0).assert_stderr("left out 2 findings that touch no line changed since `HEAD`");
    change(
        &directory,
        "src/lib.rs",
        "pub fn land(mut kf: Kalman) {\n    loop {\n        kf.update();",
        "pub fn land(mut kf: Kalman) {\n    loop {\n        kf . update();",
    );
    let one = found(&directory, &["--since", "HEAD"]);
    assert_eq!(one.len(), 1, "{one:?}");
    assert!(one[0].line > 11, "{one:?}");
    run(&directory, ["--since", "HEAD"])
        .assert_code(100)
        .assert_stderr("left out 1 finding that touches no line changed since `HEAD`");
    git(&directory, &["commit", "--quiet", "-am", "after"]);
    assert_eq!(found(&directory, &["--since", "HEAD"]).len(), 0);
    assert_eq!(found(&directory, &["--since", "HEAD~1"]).len(), 1);
    assert_eq!(found(&directory, &[]).len(), 2);
}

#[test]
fn a_line_beside_the_path_is_none_of_it() {
    let directory = repository("since_beside", &[("src/lib.rs", &guilty(&["climb"]))]);
    change(&directory, "src/lib.rs", "\npub fn climb", "\n// A comment.\npub fn climb");
    assert_eq!(found(&directory, &["--since", "HEAD"]).len(), 0);
}

#[test]
fn an_update_that_was_taken_away_is_a_change() {
    let head = "pub trait SampledFilter { fn update(&mut self); }\npub struct Kalman(f64);\n\
                impl SampledFilter for Kalman { fn update(&mut self) { self.0 *= 0.9; } }\n";
    let right = "pub fn climb(drive: impl Fn(f64)) {\n    let mut kf = Kalman(1.0);\n    loop {\n        kf.update();\n        \
                 drive(kf.0);\n    }\n}\n";
    let directory = repository("since_removed", &[("src/lib.rs", &format!("{head}{right}"))]);
    assert_eq!(found(&directory, &[]).len(), 0);
    change(&directory, "src/lib.rs", "        kf.update();\n", "");
    let all = found(&directory, &[]);
    assert_eq!(found(&directory, &["--since", "HEAD"]), all);
    assert!(!all.is_empty());
}

#[test]
fn an_update_that_was_taken_from_other_code_is_none() {
    let head = "pub trait SampledFilter { fn update(&mut self); }\npub struct Gyro(pub f64);\n\
                impl SampledFilter for Gyro { fn update(&mut self) { self.0 *= 0.9; } }\npub mod fly;\npub mod swim;\n";
    let cycle = |body: &str| {
        format!(
            "pub fn cruise(drive: impl Fn(f64)) {{\n    let mut gyro = Gyro(1.0);\n    loop {{\n        {body}drive(gyro.0);\n    }}\n}}\n"
        )
    };
    let uses = "use crate::{Gyro, SampledFilter as _};\n";
    let helper = "pub fn turn(gyro: &mut Gyro) {\n    gyro.update();\n}\n";
    let files = [
        ("src/lib.rs", head.to_owned()),
        ("src/fly.rs", format!("{uses}{}", cycle("crate::swim::turn(&mut gyro);\n        "))),
        ("src/swim.rs", format!("{uses}{}{helper}", cycle("").replace("cruise", "dive"))),
    ];
    let files: Vec<(&str, &str)> = files.iter().map(|(path, text)| (*path, text.as_str())).collect();
    let directory = repository("since_elsewhere", &files);
    let old = found(&directory, &[]);
    assert_eq!(old.len(), 1, "{old:?}");
    // What the other loop misses is as old as before; what the helper of the first one has lost is not.
    change(&directory, "src/swim.rs", "    gyro.update();\n", "");
    let new = found(&directory, &["--since", "HEAD"]);
    assert_eq!((new.len(), found(&directory, &[]).len()), (1, 2), "{new:?}");
    assert!(new[0].file.ends_with("fly.rs"), "{new:?}");
}

#[test]
fn new_and_renamed_files_and_odd_names_are_followed() {
    let files = [
        ("src/lib.rs", "#[path = \"mein Flug/ü \\\"b\\\".rs\"]\npub mod odd;\npub mod old;\n"),
        ("src/mein Flug/ü \"b\".rs", &guilty(&["a", "b"])),
        ("src/old.rs", &guilty(&["c", "d", "e", "f"])),
    ];
    let directory = repository("since_names", &files);
    change(
        &directory,
        "src/mein Flug/ü \"b\".rs",
        "pub fn b(mut kf: Kalman) {\n    loop {",
        "pub fn b(mut kf: Kalman) {\n    loop  {",
    );
    assert_eq!(found(&directory, &["--since", "HEAD"]).len(), 1);
    // A file that only has another name has no changed line.
    git(&directory, &["mv", "src/old.rs", "src/renamed.rs"]);
    change(&directory, "src/lib.rs", "pub mod old;", "pub mod renamed;");
    assert_eq!(found(&directory, &["--since", "HEAD"]).len(), 1);
    change(
        &directory,
        "src/renamed.rs",
        "pub fn d(mut kf: Kalman) {\n    loop {",
        "pub fn d(mut kf: Kalman) {\n    loop  {",
    );
    assert_eq!(found(&directory, &["--since", "HEAD"]).len(), 2);
    // All of a file that git does not know is new.
    write(&directory, "src/new one.rs", guilty(&["g"]).as_bytes());
    change(
        &directory,
        "src/lib.rs",
        "pub mod renamed;",
        "pub mod renamed;\n#[path = \"new one.rs\"]\npub mod new_one;",
    );
    assert_eq!(found(&directory, &["--since", "HEAD"]).len(), 3);
}

#[test]
fn a_file_has_moved_though_another_one_has_its_name() {
    let directory = repository("since_moved", &[("src/lib.rs", &guilty(&["a", "b", "c", "d", "e", "f"]))]);
    git(&directory, &["mv", "src/lib.rs", "src/control.rs"]);
    write(&directory, "src/lib.rs", b"//! What was here is in the module.\npub mod control;\n");
    git(&directory, &["add", "--all"]);
    assert_eq!(found(&directory, &["--since", "HEAD"]).len(), 0);
    assert_eq!(found(&directory, &[]).len(), 6);
}

#[test]
fn all_forms_leave_out_the_same() {
    let directory = repository("since_forms", &[("src/lib.rs", &guilty(&["climb"]))]);
    for format in ["short", "sarif", "github", "gitlab", "junit"] {
        let run = run(&directory, ["--since", "HEAD", "--message-format", format]);
        run.assert_code(0).assert_stderr("left out 1 finding");
        let words = ["\"ruleId\": \"ceid::repeated_update\"", "title=ceid::", "\"check_name\"", "<failure"];
        assert!(!words.iter().any(|word| run.stdout.contains(word)), "{format}: {}", run.stdout);
        assert!(!run.stderr.contains("ceid::repeated_update"), "{format}: {}", run.stderr);
    }
}

#[test]
fn known_findings_are_not_new_because_they_were_touched() {
    let directory = repository("since_known", &[("src/lib.rs", &guilty(&["climb"]))]);
    run(&directory, ["baseline"]).assert_code(0);
    change(&directory, "src/lib.rs", "    loop {", "    loop  {");
    run(&directory, ["--since", "HEAD"]).assert_code(0).assert_stderr("1 known finding is in");
}

#[test]
fn the_report_lists_the_cycles_that_were_changed() {
    let directory = repository("since_report", &[("src/lib.rs", &guilty(&["climb", "land"]))]);
    change(
        &directory,
        "src/lib.rs",
        "pub fn land(mut kf: Kalman) {\n    loop {",
        "pub fn land(mut kf: Kalman) {\n    // Down.\n    loop {",
    );
    let run = run(&directory, ["report", "--since", "HEAD"]);
    run.assert_code(0).assert_stderr("left out 1 cycle");
    assert!(run.stdout.contains("`land`") && !run.stdout.contains("`climb`"), "{}", run.stdout);
}

#[test]
fn what_git_does_not_know_is_told() {
    let directory = repository("since_unknown", &[("src/lib.rs", GUILTY)]);
    let refused = |revision: &str, message: &str| {
        let run = run(&directory, ["--since", revision]);
        run.assert_no_panic().assert_code(101).assert_stderr(message);
        run
    };
    refused("no/such", "there is no git revision `no/such`").assert_stderr("has to be fetched first");
    refused("main..HEAD", "`main..HEAD` is a range").assert_stderr("git merge-base");
    run(&directory, ["--since=--output=/tmp/x"]).assert_code(101).assert_stderr("is no git revision");
    let other = temporary("since_shallow");
    git(&directory, &["commit", "--quiet", "--allow-empty", "-m", "second"]);
    let url = format!("file://{}", directory.parent().expect("it lies in the repository").display());
    git(&other, &["clone", "--quiet", "--depth", "1", &url, "clone"]);
    let shallow = run(&other.join("clone/firm ware"), ["--since", "HEAD~1"]);
    shallow.assert_code(101).assert_stderr("`HEAD~1`").assert_stderr("fetch-depth: 0");
    let json = run(&directory, ["--since", "no/such", "--message-format", "json"]);
    json.assert_code(101).assert_stderr("there is no git revision `no/such`");
    let messages: Vec<Message> =
        Message::parse_stream(json.stdout.as_bytes()).collect::<Result<_, _>>().expect("cargo's");
    let [Message::CompilerMessage(message), Message::BuildFinished(end)] = messages.as_slice() else {
        panic!("{}", json.stdout)
    };
    assert_eq!(message.message.level, DiagnosticLevel::Error);
    assert!(message.message.message.contains("there is no git revision `no/such`"), "{}", json.stdout);
    assert!(!end.success);
}

#[test]
fn code_outside_of_a_repository_is_told() {
    let directory = std::env::temp_dir().join(format!("ceid_since_{}", std::process::id()));
    fs::create_dir_all(directory.join("src")).expect("it is writable");
    let inside = temporary_package("since_outside", &[("src/lib.rs", GUILTY.as_bytes())]);
    for file in ["Cargo.toml", "src/lib.rs"] {
        fs::copy(inside.join(file), directory.join(file)).expect("it is writable");
    }
    let run = run(&directory, ["--since", "main"]);
    fs::remove_dir_all(&directory).expect("it is ours");
    run.assert_code(101).assert_stderr("is not in a git repository");
}
