//! The targets of a package: those the manifest names, and those cargo discovers by their places.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde_json::json;
use toml::{Table, Value};

use super::super::workspace::{FoundTarget, normalized};
use super::{Manifest, TargetKind};

/// All targets of the package, in cargo's order.
pub(super) fn discover(manifest: &Manifest, package: &str, edition: &str) -> Vec<FoundTarget> {
    let mut targets = Vec::new();
    targets.extend(library(manifest, package, edition));
    for kind in [TargetKind::Bin, TargetKind::Example, TargetKind::Test, TargetKind::Bench] {
        executables(manifest, package, edition, kind, &mut targets);
    }
    targets
}

fn library(manifest: &Manifest, package: &str, edition: &str) -> Option<FoundTarget> {
    let table = manifest.section("lib");
    let path = table.and_then(|lib| lib.get("path")?.as_str()).unwrap_or("src/lib.rs");
    let path = normalized(&manifest.directory().join(path));
    if table.is_none() && !path.is_file() {
        return None;
    }
    let empty = Table::new();
    let table = table.unwrap_or(&empty);
    let name = table.get("name").and_then(Value::as_str).map_or_else(|| package.replace('-', "_"), str::to_owned);
    Some(target(table, name, TargetKind::Lib, path, edition))
}

fn executables(manifest: &Manifest, package: &str, edition: &str, kind: TargetKind, targets: &mut Vec<FoundTarget>) {
    let (folder, auto_key) = match kind {
        TargetKind::Bin => ("src/bin", "autobins"),
        TargetKind::Example => ("examples", "autoexamples"),
        TargetKind::Test => ("tests", "autotests"),
        TargetKind::Bench => ("benches", "autobenches"),
        TargetKind::Lib => return,
    };
    let discovered = places(manifest, package, kind, folder);
    let mut taken = BTreeSet::new();
    let mut named = Vec::new();
    for table in
        manifest.table.get(kind.name()).and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_table)
    {
        let Some(name) = table.get("name").and_then(Value::as_str) else { continue };
        let path = table.get("path").and_then(Value::as_str).map(|path| normalized(&manifest.directory().join(path)));
        let path = path
            .or_else(|| discovered.iter().find(|(other, _)| other == name).map(|(_, path)| path.clone()))
            .unwrap_or_else(|| manifest.directory().join(folder).join(format!("{name}.rs")));
        taken.insert(name.to_owned());
        taken.insert(path.to_string_lossy().into_owned());
        named.push(target(table, name.to_owned(), kind, path, edition));
    }
    let is_auto = manifest.section("package").and_then(|package| package.get(auto_key)?.as_bool()).unwrap_or(true);
    if is_auto {
        for (name, path) in discovered {
            if !taken.contains(&name) && !taken.contains(path.to_string_lossy().as_ref()) {
                targets.push(target(&Table::new(), name, kind, path, edition));
            }
        }
    }
    targets.extend(named);
}

/// The names and files that cargo would discover.
fn places(manifest: &Manifest, package: &str, kind: TargetKind, folder: &str) -> Vec<(String, PathBuf)> {
    let mut found = Vec::new();
    let main = manifest.directory().join("src/main.rs");
    if kind == TargetKind::Bin && main.is_file() {
        found.push((package.to_owned(), main));
    }
    let mut entries: Vec<PathBuf> = std::fs::read_dir(manifest.directory().join(folder))
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .collect();
    entries.sort();
    for path in entries {
        let Some(stem) = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()) else { continue };
        if path.extension().is_some_and(|extension| extension == "rs") && path.is_file() {
            found.push((stem, path));
        } else if path.join("main.rs").is_file() {
            let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or(stem);
            found.push((name, path.join("main.rs")));
        }
    }
    found
}

fn target(table: &Table, name: String, kind: TargetKind, src_path: PathBuf, edition: &str) -> FoundTarget {
    let edition = table.get("edition").and_then(Value::as_str).unwrap_or(edition).to_owned();
    let is_proc_macro =
        ["proc-macro", "proc_macro"].iter().any(|key| table.get(*key).and_then(Value::as_bool) == Some(true));
    let crate_types: Vec<String> = if is_proc_macro {
        vec!["proc-macro".to_owned()]
    } else {
        let named = ["crate-type", "crate_type"].iter().find_map(|key| table.get(*key)?.as_array());
        named.map_or_else(
            || vec![if kind == TargetKind::Lib { "lib" } else { "bin" }.to_owned()],
            |list| list.iter().filter_map(|value| value.as_str().map(str::to_owned)).collect(),
        )
    };
    let kinds = if kind == TargetKind::Lib { crate_types.clone() } else { vec![kind.name().to_owned()] };
    let is_tested = table
        .get("test")
        .and_then(Value::as_bool)
        .unwrap_or(matches!(kind, TargetKind::Lib | TargetKind::Bin | TargetKind::Test));
    let cargo = verbatim(&kinds, &crate_types, &name, &src_path, &edition);
    let required = table.get("required-features").and_then(Value::as_array);
    let required_features =
        required.into_iter().flatten().filter_map(|value| value.as_str().map(str::to_owned)).collect();
    FoundTarget { name, kind, src_path: normalized(&src_path), edition, required_features, is_tested, cargo }
}

/// A target as cargo would print it.
pub(in crate::project) fn verbatim(
    kinds: &[String],
    crate_types: &[String],
    name: &str,
    src_path: &Path,
    edition: &str,
) -> serde_json::Value {
    let is_lib = kinds.iter().any(|kind| kind.ends_with("lib"));
    json!({
        "kind": kinds,
        "crate_types": crate_types,
        "name": name,
        "src_path": src_path.to_string_lossy(),
        "edition": edition,
        "doc": is_lib,
        "doctest": is_lib,
        "test": is_lib,
    })
}
