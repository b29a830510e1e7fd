//! Every fix that the fixtures offer is made: what is written compiles, and the linter finds less in it and nothing new.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support::program::{Finding, Run, run};
use crate::support::root;
use crate::support::workspace::{temporary, write};

/// The files below a directory with that ending, by their path from it.
fn files(directory: &Path, ending: &str) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut open: Vec<PathBuf> = vec![directory.to_owned()];
    while let Some(next) = open.pop() {
        for entry in fs::read_dir(next).expect("the fixtures are readable") {
            let path = entry.expect("the fixtures are readable").path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|own| own == ending) {
                let name = path.strip_prefix(directory).expect("it lies there").display().to_string();
                found.insert(name.replace('\\', "/"), fs::read_to_string(&path).expect("fixtures are UTF-8"));
            }
        }
    }
    found
}

/// What is found in cases of a directory.
fn findings(directory: &Path, paths: &[&str]) -> Vec<Finding> {
    let run = run(directory, [&["--message-format", "json"], paths].concat());
    run.findings().expect("every case can be read")
}

/// Makes all fixes in a directory of cases, and compiles what they leave.
fn make_all(directory: &Path, cases: &BTreeMap<String, String>) -> (Run, BTreeMap<String, String>) {
    for (path, text) in cases {
        write(directory, path, text.as_bytes());
    }
    let before = findings(directory, &["."]).len();
    let done = run(directory, ["fix", "--unsafe-fixes", "--allow-no-vcs", "--quiet", "."]);
    assert!(matches!(done.code, Some(0 | 100)), "{}", done.stderr);
    let after = files(directory, "rs");
    assert_eq!(after.len(), cases.len(), "no file is added");
    let changed: BTreeMap<String, String> =
        after.into_iter().filter(|(path, text)| cases.get(path) != Some(text)).collect();
    assert!(findings(directory, &["."]).len() + changed.len() <= before, "each changed file has fewer findings");
    compile(directory, &changed);
    (done, changed)
}

fn compile(directory: &Path, paths: &BTreeMap<String, String>) {
    let core = root().join("ceid-core");
    let mut manifest = format!(
        "[workspace]\n\n[package]\nname = \"fixed\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[lib]\n\
         path = \"lib/lib.rs\"\n\n[dependencies]\nceid-core = {{ path = {core:?} }}\n"
    );
    for path in paths.keys() {
        let name = path.trim_end_matches(".rs").replace('/', "__");
        write!(manifest, "\n[[example]]\nname = \"{name}\"\npath = {path:?}\ncrate-type = [\"lib\"]\n")
            .expect("a String");
    }
    write(directory, "Cargo.toml", manifest.as_bytes());
    write(directory, "lib/lib.rs", b"");
    fs::copy(root().join("Cargo.lock"), directory.join("Cargo.lock")).expect("the workspace has a lock file");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(["check", "--offline", "--quiet", "--examples", "--keep-going", "--target-dir"])
        .arg(Path::new(env!("CARGO_TARGET_TMPDIR")).join("fixtures_compile_target"))
        .current_dir(directory)
        .env("RUSTFLAGS", "-Awarnings")
        .output()
        .expect("cargo is installed");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// A case in `fixtures/fixes` becomes the text beside it that ends in `.fixed`; where there is none, no fix is offered.
#[test]
fn each_fix_writes_what_is_expected() {
    let own = root().join("fixtures/fixes");
    let cases = files(&own, "rs");
    let expected = files(&own, "fixed");
    let (_, changed) = make_all(&temporary("fix_cases"), &cases);
    for (path, text) in &cases {
        let wanted = expected.get(&path.replace(".rs", ".fixed"));
        assert_eq!(changed.get(path), wanted, "{path}\n{}", changed.get(path).unwrap_or(text));
    }
    // Other line ends, a byte order mark and no last line end change nothing about what is written.
    let foreign = |text: &String| format!("\u{feff}{}", text.trim_end().replace('\n', "\r\n"));
    let directory = temporary("fix_cases_foreign");
    for (path, text) in &cases {
        write(&directory, path, foreign(text).as_bytes());
    }
    run(&directory, ["fix", "--unsafe-fixes", "--allow-no-vcs", "--quiet", "."]);
    let changed = files(&directory, "rs");
    for (path, text) in &cases {
        assert_eq!(changed[path], foreign(expected.get(&path.replace(".rs", ".fixed")).unwrap_or(text)), "{path}");
    }
    assert!(expected.keys().all(|path| cases.contains_key(&path.replace(".fixed", ".rs"))), "a result has its case");
}

#[test]
fn every_fix_of_the_rules_compiles() {
    let fixable =
        ["repeated_update", "guard_dropped_early", "guard_outside_cycle", "unused_suppression", "unknown_rule"];
    let expects = |line: &str| line.contains("//~") || line.starts_with("//@ finds:");
    let rules = root().join("fixtures/rules");
    let mut cases = files(&rules, "rs");
    cases.retain(|_, text| text.lines().any(|line| expects(line) && fixable.iter().any(|rule| line.contains(rule))));
    let paths: Vec<&str> = cases.keys().map(String::as_str).collect();
    let offered: BTreeSet<String> =
        findings(&rules, &paths).into_iter().filter(|finding| finding.is_fixable).map(|finding| finding.file).collect();
    cases.retain(|path, _| offered.contains(path));
    let (_, changed) = make_all(&temporary("fix_rules"), &cases);
    assert!(changed.len() > 40, "{:?}", changed.keys());
}
