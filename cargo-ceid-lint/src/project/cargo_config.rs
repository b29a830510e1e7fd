//! The few keys of cargo's own configuration that decide what code there is: `build.target` and `rustflags`.

use std::env;
use std::path::{Path, PathBuf};

/// What cargo's configuration says about the code.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct CargoConfig {
    /// The target cargo builds for when none is named.
    pub(super) target: Option<String>,
    /// Flags for rustc, which may hold `--cfg`.
    pub(super) rustflags: Vec<String>,
}

/// Reads the environment, `--config KEY=VALUE`, and `.cargo/config.toml` of `directory` and the directories above it.
pub(super) fn read(directory: &Path, options: &[String], target: Option<&str>) -> CargoConfig {
    let tables = tables(directory, options);
    let target = target
        .map(str::to_owned)
        .or_else(|| env::var("CARGO_BUILD_TARGET").ok())
        .or_else(|| tables.iter().find_map(build_target));
    let rustflags = flags_of_environment().unwrap_or_else(|| {
        let of_target =
            target.as_deref().map(|target| flags(&tables, &["target", target, "rustflags"])).unwrap_or_default();
        if of_target.is_empty() { flags(&tables, &["build", "rustflags"]) } else { of_target }
    });
    CargoConfig { target, rustflags }
}

/// All configuration that is in force, the strongest first.
pub(super) fn tables(directory: &Path, options: &[String]) -> Vec<toml::Table> {
    let mut tables = tables_of_options(options);
    let home = env::var_os("CARGO_HOME").map(PathBuf::from).or_else(|| Some(env::home_dir()?.join(".cargo")));
    let directories = directory.ancestors().map(|ancestor| ancestor.join(".cargo")).chain(home);
    for directory in directories {
        for name in ["config", "config.toml"] {
            if let Ok(text) = std::fs::read_to_string(directory.join(name)) {
                tables.extend(text.parse::<toml::Table>());
                break;
            }
        }
    }
    tables
}

/// What `--config` says, with a value or with a file, the strongest first.
pub(super) fn tables_of_options(options: &[String]) -> Vec<toml::Table> {
    let of_file = |path: &String| std::fs::read_to_string(path).ok()?.parse().ok();
    options.iter().rev().filter_map(|option| option.parse().ok().or_else(|| of_file(option))).collect()
}

fn build_target(table: &toml::Table) -> Option<String> {
    match table.get("build")?.get("target")? {
        toml::Value::String(target) => Some(target.clone()),
        toml::Value::Array(targets) => targets.first()?.as_str().map(str::to_owned),
        _ => None,
    }
}

fn flags_of_environment() -> Option<Vec<String>> {
    if let Ok(flags) = env::var("CARGO_ENCODED_RUSTFLAGS") {
        return Some(flags.split('\x1f').filter(|flag| !flag.is_empty()).map(str::to_owned).collect());
    }
    env::var("RUSTFLAGS").ok().map(|flags| flags.split_whitespace().map(str::to_owned).collect())
}

fn flags(tables: &[toml::Table], path: &[&str]) -> Vec<String> {
    let mut flags = Vec::new();
    // The strongest file comes last on rustc's command line, as cargo does it.
    for table in tables.iter().rev() {
        let mut value = table.get(path[0]);
        for key in &path[1..] {
            value = value.and_then(|value| value.get(key));
        }
        match value {
            Some(toml::Value::String(text)) => flags.extend(text.split_whitespace().map(str::to_owned)),
            Some(toml::Value::Array(list)) => {
                flags.extend(list.iter().filter_map(|flag| flag.as_str().map(str::to_owned)));
            }
            _ => {}
        }
    }
    flags
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(texts: &[&str]) -> Vec<toml::Table> {
        texts.iter().map(|text| text.parse().unwrap()).collect()
    }

    #[test]
    fn the_target_may_be_a_list() {
        let tables = parsed(&["build.target = [\"thumbv7em-none-eabihf\", \"x\"]"]);
        assert_eq!(build_target(&tables[0]).as_deref(), Some("thumbv7em-none-eabihf"));
    }

    #[test]
    fn flags_of_all_files_are_joined_the_nearest_last() {
        let tables = parsed(&["build.rustflags = [\"--cfg\", \"near\"]", "build.rustflags = \"--cfg far\""]);
        assert_eq!(flags(&tables, &["build", "rustflags"]), ["--cfg", "far", "--cfg", "near"]);
    }
}
