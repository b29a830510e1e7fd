//! The presets, held against cases and against the sources of the crates.
//!
//! The default run needs neither the network nor the crates: it checks the cases as they stand in the manifests, and the methods
//! against `presets/signatures`. What needs the registry is ignored, and run by `cargo-ceid-lint/presets/check.sh`.

mod signatures;

use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use cargo_ceid_lint::config::{
    FilterEntry, FilterTarget, InstancePlace, OnErr, PRESETS, Preset, Receiver as ReceiverKind,
};
use cargo_metadata::MetadataCommand;

use crate::support::case::{Case, difference};
use crate::support::program::run;
use crate::support::{root, workspace};
use signatures::Crate;

/// A type, trait or function that a preset names, and the methods that it names of it.
struct Named {
    path: String,
    methods: BTreeSet<String>,
    is_function: bool,
}

fn preset(name: &str) -> Preset {
    Preset::of(name).unwrap_or_else(|error| panic!("{error}")).expect("it is in the list")
}

fn named(preset: &Preset) -> Vec<Named> {
    let of_filter = |entry: &FilterEntry| {
        let words = entry.law.iter().flatten().chain(&entry.reset).chain(&entry.partial_reset);
        Named {
            path: entry.target.path().text.clone(),
            methods: words.map(|word| word.text.clone()).collect(),
            is_function: matches!(entry.target, FilterTarget::Function(_)),
        }
    };
    let filters = preset.filters.iter().map(of_filter);
    let cycles = preset.cycles.iter().filter_map(|entry| {
        let (path, method) = entry.target.path().text.rsplit_once("::")?;
        Some(Named { path: path.to_owned(), methods: [method.to_owned()].into(), is_function: false })
    });
    filters.chain(cycles).collect()
}

fn cases() -> PathBuf {
    root().join("fixtures/presets")
}

fn signature_file(name: &str) -> PathBuf {
    root().join(format!("cargo-ceid-lint/presets/signatures/{name}.txt"))
}

/// The signatures that are written down, by the version that they were read from.
fn written(name: &str) -> BTreeMap<String, BTreeSet<String>> {
    let text = std::fs::read_to_string(signature_file(name)).unwrap_or_default();
    let mut versions: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let mut version = String::new();
    for line in text.lines().filter(|line| !line.is_empty()) {
        match line.strip_prefix("# ") {
            Some(next) => version = next.to_owned(),
            None => {
                versions.entry(version.clone()).or_default().insert(line.to_owned());
            }
        }
    }
    versions
}

/// What changed between two versions, one line each: methods that a preset names and that are gone, or look otherwise.
fn changes(name: &str, old: (&str, &BTreeSet<String>), new: (&str, &BTreeSet<String>)) -> String {
    let mut text = String::new();
    for gone in old.1.difference(new.1) {
        let method = method_of(gone);
        let now: Vec<&str> = new.1.iter().filter(|line| method_of(line) == method).map(String::as_str).collect();
        let now = if now.is_empty() { "is gone".to_owned() } else { format!("is `{}`", now.join("`, `")) };
        writeln!(text, "{name} {}: `{method}` {now}; it was `{gone}` in {}", new.0, old.0).expect("a String");
    }
    text
}

fn method_of(line: &str) -> &str {
    line.split('(').next().unwrap_or(line)
}

#[test]
fn every_case_gives_what_it_says() {
    let directory = cases();
    let run = run(&directory, ["--workspace", "--message-format", "json"]);
    let findings = run.findings().unwrap_or_else(|error| panic!("{error}"));
    let mut failures = String::new();
    for (name, _) in PRESETS {
        for (file, is_guilty) in [("guilty", true), ("innocent", false)] {
            let path = format!("{name}/src/{file}.rs");
            let text = std::fs::read_to_string(directory.join(&path)).unwrap_or_else(|error| panic!("{path}: {error}"));
            let case = Case::parse(&text).unwrap_or_else(|error| panic!("{path}: {error}"));
            assert_eq!(!case.markers.is_empty(), is_guilty, "{path} is not what its name says");
            let own: Vec<_> =
                findings.iter().filter(|finding| Path::new(&finding.file).ends_with(&path)).cloned().collect();
            let difference = difference(&case, &own);
            if !difference.is_empty() {
                write!(failures, "{path}\n{difference}").expect("a String");
            }
        }
    }
    assert!(failures.is_empty(), "\n{failures}");
}

#[test]
fn every_case_names_the_version_that_its_preset_was_read_from() {
    for (name, _) in PRESETS {
        let manifest = std::fs::read_to_string(cases().join(name).join("Cargo.toml")).expect("every preset has cases");
        let is_pinned =
            preset(name).versions.iter().any(|version| manifest.contains(&format!("{name} = \"={version}\"")));
        assert!(is_pinned, "the cases of `{name}` depend on another version");
    }
}

#[test]
fn every_method_is_in_the_signatures() {
    let mut failures = String::new();
    for (name, _) in PRESETS {
        let preset = preset(name);
        let versions = written(name);
        for version in &preset.versions {
            let Some(lines) = versions.get(version) else {
                writeln!(failures, "{name}: no signatures of {version}").expect("a String");
                continue;
            };
            for entry in &preset.filters {
                failures += &wrong_with(name, entry, &preset.filters, lines);
            }
        }
    }
    assert!(failures.is_empty(), "\n{failures}");
}

/// What an entry says and the signatures do not.
fn wrong_with(name: &str, entry: &FilterEntry, all: &[FilterEntry], lines: &BTreeSet<String>) -> String {
    let path = &entry.target.path().text;
    let of = |path: &str, method: &str| -> Vec<String> {
        let start = format!("{path}::{method}(");
        let asynchronous = format!("{path}::async {method}(");
        lines.iter().filter(|line| line.starts_with(&start) || line.starts_with(&asynchronous)).cloned().collect()
    };
    let mut text = String::new();
    let law: Vec<&str> = entry.law.iter().flatten().map(|word| word.text.as_str()).collect();
    let found: Vec<String> = law.iter().flat_map(|method| of(path, method)).collect();
    if found.is_empty() {
        writeln!(text, "{name}: `{path}` has none of the methods of its law").expect("a String");
    }
    // Types of one entry may each have some of its methods.
    let of_one_entry = |other: &&FilterEntry| other.law == entry.law;
    for word in entry.law.iter().flatten().chain(&entry.reset).chain(&entry.partial_reset) {
        let somewhere =
            all.iter().filter(of_one_entry).any(|other| !of(&other.target.path().text, &word.text).is_empty());
        if !somewhere {
            writeln!(text, "{name}: no `{}` of `{path}`", word.text).expect("a String");
        }
    }
    for line in &found {
        let takes = line.split_once('(').map_or("", |(_, rest)| rest);
        let fits = match (entry.instance, entry.receiver) {
            (InstancePlace::Argument(_), _) => takes.contains("&mut "),
            (InstancePlace::Returned, _) => takes.contains(" -> "),
            (InstancePlace::Receiver, ReceiverKind::Exclusive) => {
                takes.starts_with("&mut self") || takes.starts_with("&'a mut self")
            }
            (InstancePlace::Receiver, ReceiverKind::Shared) => takes.starts_with("&self"),
        };
        if !fits {
            writeln!(text, "{name}: `{line}` does not have its instance where the entry says").expect("a String");
        }
    }
    if entry.on_err == OnErr::Untouched && !found.iter().any(|line| line.contains("Result<")) {
        writeln!(text, "{name}: no law of `{path}` gives a `Result`").expect("a String");
    }
    text
}

#[test]
fn a_version_that_changes_a_method_is_named() {
    let set = |lines: &[&str]| lines.iter().map(|line| (*line).to_owned()).collect::<BTreeSet<_>>();
    let old = set(&["a::F::run(&mut self)", "a::F::step(&mut self)", "a::F::reset(&mut self)"]);
    let new = set(&["a::F::run(&mut self, dt: f32)", "a::F::reset(&mut self)"]);
    assert_eq!(
        changes("a", ("1.0.0", &old), ("2.0.0", &new)),
        "a 2.0.0: `a::F::run` is `a::F::run(&mut self, dt: f32)`; it was `a::F::run(&mut self)` in 1.0.0\n\
         a 2.0.0: `a::F::step` is gone; it was `a::F::step(&mut self)` in 1.0.0\n"
    );
}

/// The version and the signatures of each preset's crate, as the graph of a workspace has it.
fn read_sources(manifest: &Path) -> Vec<(&'static str, String, BTreeSet<String>)> {
    let metadata = MetadataCommand::new().manifest_path(manifest).exec().unwrap_or_else(|error| panic!("{error}"));
    let nodes = metadata.resolve.as_ref().map_or(&[][..], |resolve| &resolve.nodes);
    let mut found = Vec::new();
    for (name, _) in PRESETS {
        let users = metadata.workspace_packages();
        let user = users.iter().find(|package| package.name.as_str() == format!("preset-{name}"));
        let user = user.unwrap_or_else(|| panic!("there is no package `preset-{name}`"));
        let node = |id: &cargo_metadata::PackageId| nodes.iter().find(|node| node.id == *id).expect("it is resolved");
        let package = node(&user.id)
            .deps
            .iter()
            .map(|dependency| &metadata[&dependency.pkg])
            .find(|package| package.name.as_str() == *name)
            .expect("the package depends on its crate");
        // Most crates have all of their methods themselves.
        let dependencies: OnceCell<Vec<Crate>> = OnceCell::new();
        let read = || {
            let all = node(&package.id).deps.iter().map(|dependency| &metadata[&dependency.pkg]);
            all.map(|package| Crate::read(package.manifest_path.as_std_path())).collect()
        };
        let dependencies = || dependencies.get_or_init(read).as_slice();
        let lines = Crate::read(package.manifest_path.as_std_path()).lines(&named(&preset(name)), &dependencies);
        found.push((*name, package.version.to_string(), lines));
    }
    found
}

#[test]
#[ignore = "needs the registry: run cargo-ceid-lint/presets/check.sh"]
fn signatures_are_those_of_the_sources() {
    let mut failures = String::new();
    for (name, version, lines) in read_sources(&cases().join("Cargo.toml")) {
        let mut versions = written(name);
        if versions.get(&version) == Some(&lines) {
            continue;
        }
        if std::env::var_os("UPDATE_SIGNATURES").is_some() {
            versions.insert(version, lines);
            let text: Vec<String> = versions
                .iter()
                .map(|(version, lines)| {
                    let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
                    format!("# {version}\n{}\n", lines.join("\n"))
                })
                .collect();
            std::fs::write(signature_file(name), text.join("\n")).expect("the directory is writable");
            continue;
        }
        let old = versions.get(&version).cloned().unwrap_or_default();
        failures += &changes(name, ("the file", &old), (&version, &lines));
        failures += &changes(name, (&version, &lines), ("the file", &old));
    }
    assert!(failures.is_empty(), "\n{failures}set UPDATE_SIGNATURES to write what was read");
}

#[test]
#[ignore = "needs the registry: run cargo-ceid-lint/presets/check.sh"]
fn newest_versions_have_the_methods() {
    let directory = workspace::temporary("presets_newest");
    let mut members = String::new();
    for (name, _) in PRESETS {
        let manifest = format!(
            "[package]\nname = \"preset-{name}\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[dependencies]\n{name} = \"*\"\n"
        );
        workspace::write(&directory, &format!("{name}/Cargo.toml"), manifest.as_bytes());
        workspace::write(&directory, &format!("{name}/src/lib.rs"), b"");
        write!(members, "\"{name}\", ").expect("a String");
    }
    let manifest = format!("[workspace]\nresolver = \"2\"\nmembers = [{members}]\n");
    workspace::write(&directory, "Cargo.toml", manifest.as_bytes());
    let mut failures = String::new();
    for (name, version, lines) in read_sources(&directory.join("Cargo.toml")) {
        let versions = written(name);
        if let Some(read) = preset(name).versions.last()
            && let Some(old) = versions.get(read)
        {
            failures += &changes(name, (read, old), (&version, &lines));
        }
    }
    assert!(failures.is_empty(), "\n{failures}");
}

#[test]
#[ignore = "needs the registry: run cargo-ceid-lint/presets/check.sh"]
fn cases_compile_against_the_real_crates() {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let target = std::env::var_os("PRESETS_TARGET_DIR")
        .map_or_else(|| Path::new(env!("CARGO_TARGET_TMPDIR")).join("presets_target"), PathBuf::from);
    let output = Command::new(cargo)
        .args(["check", "--workspace", "--quiet", "--keep-going", "--manifest-path"])
        .arg(cases().join("Cargo.toml"))
        .arg("--target-dir")
        .arg(target)
        .env("RUSTFLAGS", "-Awarnings")
        .output()
        .expect("cargo is installed");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
