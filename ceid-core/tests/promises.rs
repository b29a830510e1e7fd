//! What the crate promises of itself and no program can show: dependencies, `unsafe`, the names of the paper, and that what
//! remains possible to get wrong has a rule of the linter or says that it has none.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

#[test]
fn no_dependency_is_mandatory() {
    let manifest = read("Cargo.toml");
    let lines =
        manifest.lines().skip_while(|line| *line != "[dependencies]").take_while(|line| *line != "[dev-dependencies]");
    let declared: Vec<_> = lines.filter(|line| line.contains(" = ") && !line.starts_with('[')).collect();
    assert!(declared.len() >= 4, "{declared:?}");
    let mandatory: Vec<_> = declared.iter().filter(|line| !line.contains("optional = true")).collect();
    assert!(mandatory.is_empty(), "{mandatory:?}");
}

#[test]
fn no_default_feature_has_a_dependency() {
    let manifest = read("Cargo.toml");
    let features: Vec<_> = manifest.lines().skip_while(|line| *line != "[features]").collect();
    let of = |name: &str| features.iter().find_map(|line| line.strip_prefix(&format!("{name} = "))).map(str::to_owned);
    assert_eq!(of("default").as_deref(), Some("[\"std\", \"must-register\"]"));
    assert_eq!(of("std").as_deref(), Some("[\"alloc\"]"));
    for name in ["alloc", "must-register"] {
        assert_eq!(of(name).as_deref(), Some("[]"), "{name}");
    }
}

/// The triple buffer, the priority-inheriting lock, and the system calls of Linux.
#[test]
fn three_files_have_unsafe_code_and_each_place_its_reason() {
    let mut unsafe_files = BTreeSet::new();
    for file in sources() {
        let text = fs::read_to_string(&file).expect("a source file can be read");
        let lines: Vec<_> = text.lines().collect();
        for (at, line) in lines.iter().enumerate() {
            let code = line.split("//").next().unwrap_or_default();
            if !["unsafe {", "unsafe impl", "unsafe fn"].iter().any(|it| code.contains(it)) {
                continue;
            }
            unsafe_files.insert(file.file_name().expect("it is a file").to_string_lossy().into_owned());
            let has_reason = lines[at.saturating_sub(6)..at]
                .iter()
                .any(|line| line.contains("SAFETY:") || line.contains("# Safety"));
            assert!(has_reason, "{}:{}: {line}", file.display(), at + 1);
        }
    }
    let known = ["latest.rs", "priority_inheriting.rs", "system_calls.rs"].map(str::to_owned);
    assert_eq!(unsafe_files, BTreeSet::from(known));
}

#[test]
fn every_other_module_forbids_unsafe_code() {
    assert!(read("src/lib.rs").contains("#![deny(unsafe_code)]") && read("src/lib.rs").contains("#![no_std]"));
    for parent in ["cycle", "exchange", "filter", "thread"] {
        let text = read(&format!("src/{parent}/mod.rs"));
        if text.contains("#![forbid(unsafe_code)]") {
            continue;
        }
        let lines: Vec<_> = text.lines().collect();
        for (at, line) in lines.iter().enumerate().filter(|(_, line)| line.starts_with("mod ") && line.ends_with(';')) {
            let above = lines[..at].iter().rev().take_while(|line| line.starts_with("#["));
            let says = above.filter(|line| line.contains("unsafe_code")).count();
            assert_eq!(says, 1, "src/{parent}/mod.rs:{}: {line}", at + 1);
        }
    }
}

/// Whoever searches the documentation for a name of the paper finds what has its place.
#[test]
fn the_names_of_the_paper_lead_here() {
    let all: String = sources().iter().map(|file| fs::read_to_string(file).expect("it can be read")).collect();
    for name in [
        "CEID",
        "CEIDAll",
        "cyclicExecution",
        "UniqueCheck",
        "CEIDEqualComparable",
        "is_update_per_cycle_once",
        "RealtimeFunctionalityIF",
        "RealtimeThreadIF",
        "ChronoCycleLogicalThread",
        "RTPreemptCycleLogicalThread",
        "TransactionIO",
        "Locker",
        "setInput",
        "getInput",
    ] {
        assert!(all.contains(&format!("doc(alias = \"{name}\")")), "{name}");
    }
}

/// One module a platform, so that no function has a part that only some targets compile.
#[test]
fn no_function_body_is_configured() {
    for file in sources() {
        let text = fs::read_to_string(&file).expect("a source file can be read");
        for (at, line) in text.lines().enumerate() {
            let is_inside = line.starts_with("        ") && !line.trim_start().starts_with("//");
            let is_configured = is_inside && (line.contains("#[cfg(") || line.contains("cfg!("));
            assert!(!is_configured, "{}:{}: {line}", file.display(), at + 1);
        }
    }
}

#[test]
fn each_mistake_that_remains_has_a_rule_of_the_linter_or_says_that_it_has_none() {
    let readme = read("README.md");
    let section = readme.split("## What remains possible to get wrong").nth(1).expect("it has that section");
    let rows = section.lines().skip_while(|line| !line.starts_with("| ---")).skip(1);
    let found_by: Vec<_> =
        rows.take_while(|line| line.starts_with('|')).filter_map(|row| row.rsplit('|').nth(1)).map(str::trim).collect();
    assert!(found_by.len() > 10, "{found_by:?}");
    for cell in found_by {
        let rules = cell.split('`').skip(1).step_by(2).filter(|name| *name != "let_underscore_drop");
        let rules: Vec<_> = rules.collect();
        assert!(cell == "no rule" || !rules.is_empty(), "{cell}");
        for rule in rules {
            // The linter is beside this crate in the workspace only.
            let texts = root().join("../cargo-ceid-lint/src/rules");
            assert!(!texts.is_dir() || texts.join(format!("{rule}.md")).is_file(), "no rule is called {rule}");
        }
    }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(file: &str) -> String {
    fs::read_to_string(root().join(file)).expect("the crate has this file")
}

fn sources() -> Vec<PathBuf> {
    let source = root().join("src");
    let files = |folder: PathBuf| {
        fs::read_dir(folder).expect("the sources are there").map(|entry| entry.expect("it can be read").path())
    };
    let folders = ["cycle", "exchange", "filter", "thread"].map(|folder| source.join(folder));
    folders
        .into_iter()
        .chain([source])
        .flat_map(files)
        .filter(|file| file.extension().is_some_and(|it| it == "rs"))
        .collect()
}
