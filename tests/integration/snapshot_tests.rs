//! The function with which other test suites keep what the linter says, on the crate that shows how.

use std::fs;
use std::path::Path;

use cargo_ceid_lint::{Subject, snapshot};

use crate::support::root;
use crate::support::workspace::{GUILTY, committed, temporary, temporary_package, write};

#[test]
fn the_example_keeps_what_is_found() {
    let directory = root().join("fixtures/snapshot_tested");
    let kept = fs::read_to_string(directory.join("tests/snapshots/lint__findings_are_the_known_ones.snap"));
    let kept = kept.expect("the example was run with `INSTA_UPDATE=always`");
    let kept = kept.splitn(3, "---\n").nth(2).expect("a snapshot has a head");
    // The example has the linter from this workspace, where others have it from a registry: its sources are no part of the subject.
    let text = fs::read(directory.join("src/lib.rs")).expect("the example has a crate");
    let tests = fs::read(directory.join("tests/lint.rs")).expect("the example has a test");
    let alone = temporary_package("snapshot_alone", &[("src/lib.rs", &text), ("tests/lint.rs", &tests)]);
    assert_eq!(snapshot(Subject::Directory(&alone)).expect("it is a package").trim_end(), kept.trim_end());
}

#[test]
fn nothing_of_the_machine_is_in_the_text() {
    let text = snapshot(Subject::Directory(&committed("two_crates"))).expect("it is a workspace");
    assert!(text.contains("rover/src/main.rs:17") && !text.contains(&root().display().to_string()), "{text}");
}

#[test]
fn a_dependency_outside_of_the_workspace_is_named_without_its_directory() {
    let directory = temporary("snapshot_outside");
    let manifest = |name: &str, rest: &str| {
        format!("[workspace]\n[package]\nname = \"{name}\"\nversion = \"0.0.0\"\nedition = \"2024\"\n{rest}")
    };
    write(&directory, "filters/Cargo.toml", manifest("filters", "").as_bytes());
    let twice = "pub fn twice(kf: &mut Kalman) { kf.update(); kf.update(); }\n";
    write(&directory, "filters/src/lib.rs", format!("{GUILTY}{twice}").as_bytes());
    write(
        &directory,
        "robot/Cargo.toml",
        manifest("robot", "[dependencies]\nfilters = { path = \"../filters\" }\n").as_bytes(),
    );
    let robot = b"pub fn walk(mut kf: filters::Kalman) { loop { filters::twice(&mut kf); } }\n";
    write(&directory, "robot/src/lib.rs", robot);
    let text = snapshot(Subject::Directory(&directory.join("robot"))).expect("it is a package");
    assert!(
        text.contains("`kf` is updated more than once") && !text.contains(&directory.display().to_string()),
        "{text}"
    );
}

#[test]
fn a_wrong_configuration_is_part_of_the_text() {
    let directory = temporary("snapshot_configuration");
    write(&directory, "Cargo.toml", b"[workspace]\n[package]\nname = \"a\"\nversion = \"0.0.0\"\n");
    write(&directory, "src/lib.rs", b"");
    write(&directory, "ceid-lint.toml", b"[lints]\nmised_update = \"deny\"\n");
    let text = snapshot(Subject::Directory(Path::new(&directory))).expect("it is a package");
    assert!(text.contains("missed_update"), "{text}");
}
