//! Every case file is real Rust: a throw-away package for each rule holds its cases as modules, and cargo checks them all.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support::{root, workspace};

/// Runs `cargo check --offline`; the manifest decides what is checked.
#[track_caller]
fn cargo_check(manifest: &Path, target: &str, flags: &[&str]) {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(["check", "--offline", "--quiet", "--manifest-path"])
        .arg(manifest)
        .arg("--target-dir")
        .arg(Path::new(env!("CARGO_TARGET_TMPDIR")).join(target))
        .args(flags)
        .env("RUSTFLAGS", "-Awarnings")
        .output()
        .expect("cargo is installed");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn cases(directory: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(directory).expect("the fixtures are readable") {
        let path = entry.expect("the fixtures are readable").path();
        if path.is_dir() {
            cases(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// Whether a case speaks of its crate, so that it has to be one.
pub(crate) fn is_crate(text: &str) -> bool {
    let of_crate = ["crate::", "extern crate", "macro_export"];
    text.lines().any(|line| line.starts_with("#![")) || of_crate.iter().any(|word| text.contains(word))
}

#[test]
fn cases_compile() {
    let root = root();
    let directory = workspace::temporary("fixtures_compile");
    let core = root.join("ceid-core");
    let mut paths = Vec::new();
    cases(&root.join("fixtures/rules"), &mut paths);
    paths.sort();
    // A package for each rule and a module for each case: what cargo does for a target grows with the targets of its package.
    let mut packages: BTreeMap<String, (String, String)> = BTreeMap::new();
    for path in &paths {
        let rule = path.parent().and_then(Path::file_name).expect("a case lies in its rule's folder");
        let name = path.file_stem().expect("it has a name").to_string_lossy();
        let (manifest, modules) = packages.entry(rule.to_string_lossy().into_owned()).or_insert_with_key(|rule| {
            let manifest = format!(
                "[package]\nname = \"{rule}\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[dependencies]\n\
                 ceid-core = {{ path = {core:?} }}\n"
            );
            (manifest, String::new())
        });
        if is_crate(&std::fs::read_to_string(path).expect("a case is readable")) {
            write!(manifest, "\n[[example]]\nname = \"{name}\"\npath = {path:?}\ncrate-type = [\"lib\"]\n")
        } else {
            writeln!(modules, "#[path = {path:?}]\npub mod case_{name};")
        }
        .expect("a String");
    }
    let members: Vec<&String> = packages.keys().collect();
    let whole = format!("[workspace]\nresolver = \"3\"\nmembers = {members:?}\n");
    workspace::write(&directory, "Cargo.toml", whole.as_bytes());
    for (rule, (manifest, modules)) in &packages {
        workspace::write(&directory, &format!("{rule}/Cargo.toml"), manifest.as_bytes());
        workspace::write(&directory, &format!("{rule}/src/lib.rs"), modules.as_bytes());
    }
    // The versions are those of this workspace, so that nothing has to be looked up.
    std::fs::copy(root.join("Cargo.lock"), directory.join("Cargo.lock")).expect("the workspace has a lock file");
    cargo_check(&directory.join("Cargo.toml"), "fixtures_compile_target", &["--lib", "--examples", "--keep-going"]);
}

#[test]
fn workspaces_compile() {
    for name in [
        "figure3_legacy",
        "figure3_guarded",
        "two_crates",
        "macros_between_crates",
        "path_modules",
        "configured_attempts",
        "configured_laws",
        "configured_instances",
        "configured_estimates",
        "configured_keys",
        "configured_states",
        "configured_names",
        "configured_cycles",
        "configured_guards",
        "configured_guard_forms",
        "configured_members",
        "init_robot",
        "init_nothing",
        "init_clash",
        "init_lookalikes",
        "legacy_robot",
    ] {
        let manifest = workspace::committed(name).join("Cargo.toml");
        cargo_check(&manifest, "fixtures_compile_target", &["--workspace"]);
    }
    let manifest = workspace::committed("path_modules").join("Cargo.toml");
    cargo_check(&manifest, "fixtures_compile_target", &["--features", "turbo"]);
}
