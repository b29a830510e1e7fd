//! The cases of `fixtures/migrate`, against what the program writes and says.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use super::{binary, cases, entries, migrate, package, read};
use crate::support::program::run;
use crate::support::{root, workspace};

/// Holds a text against a file, or writes it where that is asked for.
#[track_caller]
fn check_text(found: &str, expected: &Path) {
    if std::env::var_os("CEID_MIGRATE_BLESS").is_some() {
        fs::create_dir_all(expected.parent().expect("it lies in a case")).expect("the cases are writable");
        fs::write(expected, found).expect("the cases are writable");
        return;
    }
    assert!(found == read(expected), "{} is not what came out:\n{found}", expected.display());
}

/// Migrates all cases of a folder at once, and holds each result against its `after.rs`.
#[track_caller]
fn check(folder: &str, flags: &[&str]) {
    let cases = entries(&cases().join(folder));
    let before: Vec<(String, String)> =
        cases.iter().map(|(name, path)| (name.clone(), read(&path.join("before.rs")))).collect();
    let directory = package(&format!("migrate_{folder}"), &before);
    migrate(&directory, &[&["--all"], flags].concat()).assert_code(0).assert_no_panic();
    for (name, path) in &cases {
        check_text(&binary(&directory, name), &path.join("after.rs"));
    }
    // Loops that are migrated are guarded, and a second run has nothing to do.
    let report = run(&directory, ["report", "--message-format", "json"]);
    let by_hand = report.pairs().expect("the report is read");
    let by_hand: Vec<String> =
        by_hand.iter().filter(|pair| pair.verdict != "guarded").map(ToString::to_string).collect();
    // Those that a gate updates less often, those whose function returns above its guard, the one that its loop reads after the update,
    // and what is called that has a loop of its own.
    let stays = |pair: &String| {
        let kept = [
            "slow gated",
            "resting gated",
            "read_later once",
            "copter.notches[*] per_sample",
            "closure heading per_sample",
        ];
        kept.iter().any(|own| pair.contains(own))
    };
    assert!(by_hand.iter().all(stays), "{by_hand:#?}");
    let is_partly = by_hand.iter().any(|pair| pair.contains("read_later"));
    let said = if is_partly { "`read_later` is used here after its update" } else { "nothing to migrate" };
    migrate(&directory, &[&["--all"], flags].concat()).assert_code(0).assert_stderr(said);
    for (name, path) in &cases {
        assert_eq!(binary(&directory, name), read(&path.join("after.rs")), "{name}");
    }
}

#[test]
fn what_keeps_its_behaviour_is_migrated() {
    check("migrated", &[]);
}

#[test]
fn what_changes_its_behaviour_is_migrated_if_asked_for() {
    check("changed", &["--unsafe-fixes"]);
}

#[test]
fn what_changes_its_behaviour_is_left_otherwise() {
    let cases = entries(&cases().join("changed"));
    let before: Vec<(String, String)> =
        cases.iter().map(|(name, path)| (name.clone(), read(&path.join("before.rs")))).collect();
    let directory = package("migrate_unchanged", &before);
    let said = migrate(&directory, &["--all"]);
    said.assert_code(0).assert_stderr("because the program would do something else");
    for (name, text) in &before {
        assert_eq!(binary(&directory, name), *text, "{name}");
    }
}

/// The reasons that a text is marked with: line, and what the reason holds.
fn marked(text: &str) -> Vec<(usize, &str)> {
    let lines = (1..).zip(text.lines());
    lines.filter_map(|(line, text)| Some((line, text.split_once("//~ ")?.1))).collect()
}

#[test]
fn what_is_refused_says_why() {
    let cases: Vec<(String, String)> =
        entries(&cases().join("refused")).into_iter().map(|(name, path)| (name, read(&path))).collect();
    let directory = package("migrate_refused", &cases);
    // No trait has a law that is `const`.
    workspace::write(&directory, "ceid-lint.toml", b"[[filter]]\ntype = \"crate::Crc\"\nlaw = \"tick\"\n");
    let said = migrate(&directory, &["--all"]);
    said.assert_code(0).assert_no_panic();
    // Each refusal is a head with its reasons below it.
    let mut found: BTreeSet<(String, usize, String)> = BTreeSet::new();
    let mut file = String::new();
    for line in said.stderr.lines() {
        if let Some(head) = line.strip_prefix("warning: src/bin/") {
            head.split_once(".rs:").expect("a file and a line").0.clone_into(&mut file);
        } else if let Some((number, reason)) = line.strip_prefix("  line ").and_then(|rest| rest.split_once(": ")) {
            found.insert((file.clone(), number.parse().expect("a line"), reason.to_owned()));
        }
    }
    let mut wrong = Vec::new();
    for (name, text) in &cases {
        assert_eq!(binary(&directory, name), *text, "{name}");
        let marks = marked(text);
        assert!(!marks.is_empty(), "{name} says nothing of what is refused");
        for (line, mark) in &marks {
            let at =
                found.iter().find(|(file, at, reason)| file == name && at == line && reason.contains(mark)).cloned();
            match at {
                Some(at) => drop(found.remove(&at)),
                None => wrong.push(format!("{name}:{line}: nothing about `{mark}`")),
            }
        }
    }
    wrong.extend(found.iter().map(|(name, line, reason)| format!("{name}:{line}: not marked: {reason}")));
    assert!(wrong.is_empty(), "{wrong:#?}\n{}", said.stderr);
}

/// A panic that a test beside the sources catches or expects shows what a guard does where an iteration panics.
#[test]
fn tests_beside_the_sources_see_panics() {
    let text = "\
trait SampledFilter { fn update(&mut self); }
struct Lag(i64);
impl SampledFilter for Lag { fn update(&mut self) { self.0 += 1; } }
struct Tape([i64; 3], usize);
impl SampledFilter for Tape { fn update(&mut self) { self.1 += self.0[self.1] as usize; } }
fn lag(lag: &mut Lag, inputs: &[i64]) {
    for input in inputs {
        assert!(*input % 2 == 0);
        lag.update();
    }
}
fn tape(inputs: &[i64; 4]) -> i64 {
    let (mut sum, mut tape) = (0, Tape([1; 3], 0));
    for step in 0..3 {
        sum += inputs[tape.1 + step];
        tape.update();
    }
    sum
}
fn main() {
    lag(&mut Lag(0), &[2, 4]);
    println!(\"{}\", tape(&[1; 4]));
}
";
    let check = |name: &str, test: &str, said: &str, migrated: u8| {
        let directory = package(name, &[("rig".to_owned(), text.to_owned())]);
        workspace::write(&directory, "tests/panics.rs", test.as_bytes());
        let run = migrate(&directory, &["--all"]);
        run.assert_code(0).assert_stderr(said).assert_stderr(&format!("migrated {migrated} of 2 loops"));
    };
    check(
        "migrate_caught_beside",
        "#[test] fn it_is_caught() { assert!(std::panic::catch_unwind(|| panic!()).is_err()); }\n",
        "line 8: the law of `lag` runs as well where the iteration panics, and the program catches panics",
        0,
    );
    check(
        "migrate_expected_beside",
        "#[test] #[should_panic] fn it_panics() { panic!(); }\n",
        "line 15: where the iteration panics, `update` of `tape` runs as well, and may panic a second time, which ends the program, and \
         tests expect panics",
        1,
    );
}

/// Copies a case's files into a directory.
pub(super) fn copy(from: &Path, to: &Path, core: &str) {
    for (_, path) in entries(from) {
        let target = to.join(path.file_name().expect("it has a name"));
        if path.is_dir() {
            fs::create_dir_all(&target).expect("the directory is writable");
            copy(&path, &target, core);
        } else {
            fs::write(target, read(&path).replace("CEID_CORE", core)).expect("the directory is writable");
        }
    }
}

fn files(directory: &Path, below: &Path, found: &mut Vec<(String, String)>) {
    for (_, path) in entries(below) {
        if path.is_dir() {
            files(directory, &path, found);
        } else {
            let name = path.strip_prefix(directory).expect("it lies below").to_string_lossy().replace('\\', "/");
            found.push((name, read(&path)));
        }
    }
}

/// A manifest without the way from it to ceid-core, which depends on where the tests write.
fn without_place(text: &str) -> String {
    let place = |line: &str| match line.split_once("path = \"../") {
        Some((begin, rest)) if rest.contains("ceid-core\"") => format!("{begin}path = \"CEID_CORE\" }}\n"),
        _ => line.to_owned(),
    };
    text.split_inclusive('\n').map(place).collect()
}

#[test]
fn whole_workspaces_are_migrated() {
    let core = root().join("ceid-core").to_string_lossy().into_owned();
    for (name, path) in entries(&cases().join("workspaces")) {
        let directory = workspace::temporary(&format!("migrate_workspace_{name}"));
        copy(&path.join("before"), &directory, &core);
        fs::copy(root().join("Cargo.lock"), directory.join("Cargo.lock")).expect("the workspace has a lock file");
        // What its own tests say of it holds before and after.
        super::compiled::cargo(&directory, &["test", "--workspace", "--quiet"]);
        fs::remove_file(directory.join("Cargo.lock")).expect("the workspace is writable");
        let form = fs::read_to_string(directory.join("rustfmt.toml")).unwrap_or_default();
        workspace::write(&directory, "rustfmt.toml", format!("disable_all_formatting = true\n{form}").as_bytes());
        migrate(&directory, &["--all", "--ceid-core-path", &core]).assert_code(0).assert_no_panic();
        match form.as_str() {
            "" => fs::remove_file(directory.join("rustfmt.toml")).expect("the workspace is writable"),
            form => workspace::write(&directory, "rustfmt.toml", form.as_bytes()),
        }
        let (mut before, mut after) = (Vec::new(), Vec::new());
        files(&path.join("before"), &path.join("before"), &mut before);
        files(&directory, &directory, &mut after);
        for (file, text) in after {
            let text = without_place(&text).replace(&core, "CEID_CORE");
            let is_changed = !before.contains(&(file.clone(), text.clone()));
            let expected = path.join("after").join(&file);
            assert!(is_changed || !expected.exists(), "{name}: {file} did not change");
            if is_changed {
                check_text(&text, &expected);
            }
        }
        fs::copy(root().join("Cargo.lock"), directory.join("Cargo.lock")).expect("the workspace has a lock file");
        super::compiled::cargo(&directory, &["test", "--workspace", "--quiet"]);
        if before.iter().any(|(file, text)| file.ends_with("Cargo.toml") && text.contains("[features]")) {
            super::compiled::cargo(&directory, &["test", "--workspace", "--quiet", "--no-default-features"]);
        }
        let pairs = run(&directory, ["report", "--message-format", "json"]).pairs().expect("the report is read");
        let by_hand: Vec<String> =
            pairs.iter().filter(|pair| pair.verdict != "guarded").map(ToString::to_string).collect();
        assert!(!pairs.is_empty() && by_hand.is_empty(), "{name}: {by_hand:#?}");
    }
}
