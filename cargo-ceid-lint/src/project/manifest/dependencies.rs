//! The dependency tables of a manifest.

use std::path::{Path, PathBuf};

use toml::{Table, Value};

use super::super::workspace::{FoundDependency, normalized};
use super::Manifest;

/// Reads all dependencies that are in scope in the targets that are read; those of build scripts are not.
pub(super) fn read(manifest: &Manifest, workspace: Option<&Manifest>) -> Vec<FoundDependency> {
    let mut tables: Vec<&Table> = vec![&manifest.table];
    for target in manifest.section("target").into_iter().flat_map(Table::values) {
        tables.extend(target.as_table());
    }
    let mut dependencies = Vec::new();
    for table in tables {
        for (section, is_dev) in [("dependencies", false), ("dev-dependencies", true), ("dev_dependencies", true)] {
            for (key, value) in table.get(section).and_then(Value::as_table).into_iter().flatten() {
                let mut dependency = one(key, value, manifest.directory(), workspace);
                dependency.is_dev = is_dev;
                dependencies.push(dependency);
            }
        }
    }
    dependencies
}

fn one(key: &str, value: &Value, directory: &Path, workspace: Option<&Manifest>) -> FoundDependency {
    if value.get("workspace").and_then(Value::as_bool) == Some(true) {
        let shared = workspace.and_then(|root| {
            let value = root.section("workspace")?.get("dependencies")?.get(key)?;
            Some(plain(key, value, root.directory()))
        });
        let mut dependency = shared.unwrap_or_else(|| plain(key, value, directory));
        dependency.is_optional = value.get("optional").and_then(Value::as_bool).unwrap_or(false);
        dependency.features.extend(strings(value, "features"));
        return dependency;
    }
    plain(key, value, directory)
}

fn plain(key: &str, value: &Value, directory: &Path) -> FoundDependency {
    let package = value.get("package").and_then(Value::as_str);
    let flag = |key: &str, default: bool| value.get(key).and_then(Value::as_bool).unwrap_or(default);
    FoundDependency {
        package_name: package.unwrap_or(key).to_owned(),
        rename: package.is_some().then(|| key.to_owned()),
        is_optional: flag("optional", false),
        is_dev: false,
        default_features: flag("default-features", true),
        features: strings(value, "features"),
        path: value.get("path").and_then(Value::as_str).map(|path| normalized(&directory.join(PathBuf::from(path)))),
        is_git: value.get("git").is_some(),
    }
}

fn strings(value: &Value, key: &str) -> Vec<String> {
    let list = value.get(key).and_then(Value::as_array);
    list.into_iter().flatten().filter_map(|value| value.as_str().map(str::to_owned)).collect()
}
