//! Finds and reads the configuration files.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use toml::de::DeTable;

use super::reader::{File, Table, Value};
use super::{
    Config, ConfigError, CycleEntry, FilterEntry, GuardEntry, LevelOverride, LevelSource, Presets, Section, glob,
    levels,
};
use crate::diagnostic::Level;
use crate::source::{ReadError, ReadSource};

/// What a section holds for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Scope {
    /// Every package of the workspace with this root.
    Workspace(PathBuf),
    /// The package with this manifest.
    Package(PathBuf),
}

/// The file beside the workspace manifest.
pub const FILE_NAME: &str = "ceid-lint.toml";

/// The keys of a section.
pub const KEYS: &[&str] = &["presets", "exclude", "lints", "filter", "cycle", "guard"];

/// Reads the configuration of the workspaces with these roots and of the packages with these manifests from `source`.
///
/// # Errors
/// What is wrong in the first file in which something is.
pub fn load<'a>(
    roots: impl IntoIterator<Item = &'a Path>,
    manifests: impl IntoIterator<Item = &'a Path>,
    source: &dyn ReadSource,
) -> Result<Config, ConfigError> {
    let mut config = Config::default();
    let mut done: Vec<&Path> = Vec::new();
    for root in roots {
        if done.contains(&root) {
            continue;
        }
        done.push(root);
        let scope = || Scope::Workspace(root.to_owned());
        config.sections.extend(read_metadata(&root.join("Cargo.toml"), "workspace", scope(), source)?);
        let path = root.join(FILE_NAME);
        // A link to nothing is there as well, and meant as a configuration; so is what an editor has not saved yet.
        if path.symlink_metadata().is_ok() || source.exists(&path) {
            let text = source.read(&path).map_err(|error| {
                let (why, help) = match &error {
                    ReadError::Utf16 | ReadError::NotUtf8 { .. } => {
                        (error.to_string(), "save it as UTF-8, the only encoding of TOML")
                    }
                    _ if path.is_file() => (error.to_string(), error.remedy()),
                    _ => ("it is not a file".to_owned(), "make it a file with the configuration, or remove it"),
                };
                let message = format!("cannot read `{}`: {why}", path.display());
                ConfigError::without_place(message).help(help)
            })?;
            config.sections.push(read_file(&path, &text, scope())?);
        }
    }
    for manifest in manifests {
        config.sections.extend(read_metadata(manifest, "package", Scope::Package(manifest.to_owned()), source)?);
    }
    Ok(config)
}

fn read_file(path: &Path, text: &str, scope: Scope) -> Result<Section, ConfigError> {
    let file = File { path, text };
    with_text(text, || {
        let table = DeTable::parse(text).map_err(|error| file.syntax_error(&error))?;
        section(&Table { file, table: table.get_ref(), range: 0..0 }, scope)
    })
}

/// Reads `[workspace.metadata.ceid-lint]` or `[package.metadata.ceid-lint]`, if it is there.
fn read_metadata(
    manifest: &Path,
    owner: &str,
    scope: Scope,
    source: &dyn ReadSource,
) -> Result<Option<Section>, ConfigError> {
    // A manifest that cannot be read is cargo's business, and was reported when the project was loaded.
    let Ok(text) = source.read(manifest) else { return Ok(None) };
    if !text.contains("ceid-lint") {
        return Ok(None);
    }
    let file = File { path: manifest, text: &text };
    with_text(&text, || {
        let Ok(root) = DeTable::parse(&text) else { return Ok(None) };
        let metadata =
            root.get_ref().get(owner).and_then(|owner| owner.get_ref().get("metadata")?.get_ref().get("ceid-lint"));
        let Some(value) = metadata else { return Ok(None) };
        let table = Value { file, value }.table("a table")?;
        section(&table, scope).map(Some)
    })
}

fn with_text<T>(text: &str, read: impl FnOnce() -> Result<T, ConfigError>) -> Result<T, ConfigError> {
    read().map_err(|error| error.in_text(&Arc::from(text)))
}

fn section(table: &Table<'_>, scope: Scope) -> Result<Section, ConfigError> {
    let mut errors = Vec::new();
    errors.extend(table.only(KEYS).err());
    let section = Section {
        scope,
        path: table.file.path.to_owned(),
        text: Arc::from(table.file.text),
        presets: table.get("presets").and_then(|value| read_or_note(&mut errors, presets(value).map(Some))),
        exclude: table.get("exclude").map_or_else(Vec::new, |value| read_or_note(&mut errors, patterns(value))),
        lints: table.get("lints").map_or_else(Vec::new, |value| read_or_note(&mut errors, lints(value))),
        filters: read_or_note(&mut errors, entries(table, "filter", FilterEntry::read)),
        cycles: read_or_note(&mut errors, entries(table, "cycle", CycleEntry::read)),
        guards: read_or_note(&mut errors, entries(table, "guard", GuardEntry::read)),
    };
    errors.sort_by_key(|error| error.place.as_ref().map(|place| place.range.start));
    ConfigError::all(errors).map_or(Ok(section), Err)
}

/// What was read, or nothing, so that the rest is read as well and all errors are told at once.
fn read_or_note<T: Default>(errors: &mut Vec<ConfigError>, read: Result<T, ConfigError>) -> T {
    read.unwrap_or_else(|error| {
        errors.push(error);
        T::default()
    })
}

/// Patterns of paths; they begin in the directory of the manifest, with or without `./`.
fn patterns(value: Value<'_>) -> Result<Vec<String>, ConfigError> {
    value.strings()?;
    let pattern = |value: Value<'_>| {
        let text = value.string()?;
        if glob::is_unclosed(text) {
            return Err(value
                .error(format!("the pattern `{text}` has a `[` that nothing closes"))
                .help("close the set as in `[ab]`, or write `[[]` for the bracket itself"));
        }
        if let Some((before, (choice, behind))) = glob::choice(text) {
            let each: Vec<String> = choice.split(',').map(|one| format!("\"{before}{one}{behind}\"")).collect();
            return Err(value
                .error(format!("the pattern `{text}` has a choice in braces, which no pattern has"))
                .help(format!("write a pattern for each: {}", each.join(", "))));
        }
        Ok(text.strip_prefix("./").unwrap_or(text).to_owned())
    };
    value.list_or_one().into_iter().map(pattern).collect()
}

/// The entries of a preset.
pub(super) fn preset_entries(table: &Table<'_>) -> Result<(Vec<FilterEntry>, Vec<CycleEntry>), ConfigError> {
    Ok((entries(table, "filter", FilterEntry::read)?, entries(table, "cycle", CycleEntry::read)?))
}

fn entries<T>(
    table: &Table<'_>,
    key: &str,
    read: impl Fn(&Table<'_>) -> Result<Vec<T>, ConfigError>,
) -> Result<Vec<T>, ConfigError> {
    let Some(value) = table.get(key) else { return Ok(Vec::new()) };
    if value.is_table() {
        return Err(value.error(format!("`{key}` is a list of tables")).help(format!("write `[[{key}]]`")));
    }
    let (mut entries, mut errors) = (Vec::new(), Vec::new());
    for entry in value.list()? {
        entries.extend(read_or_note(&mut errors, entry.table("a table").and_then(|table| read(&table))));
    }
    ConfigError::all(errors).map_or(Ok(entries), Err)
}

fn presets(value: Value<'_>) -> Result<Presets, ConfigError> {
    if value.value.get_ref().is_array() {
        let names = value.list()?.into_iter().map(|name| Ok((name.string()?.to_owned(), name.place())));
        return Ok(Presets::Named(names.collect::<Result<_, ConfigError>>()?));
    }
    match value.string()? {
        "auto" => Ok(Presets::Auto),
        "none" => Ok(Presets::None),
        word => {
            Err(value.error(format!("unknown value `{word}`")).help("write `\"auto\"`, `\"none\"`, or a list of names"))
        }
    }
}

fn lints(value: Value<'_>) -> Result<Vec<LevelOverride>, ConfigError> {
    let table = value.table("a table of rules and levels")?;
    let mut overrides: Vec<LevelOverride> = Vec::new();
    let mut errors = Vec::new();
    for (key, place, value) in table.entries() {
        let name = levels::without_prefix(key).to_owned();
        if overrides.iter().any(|known| known.name == name) {
            let error = ConfigError::at(place, format!("`{name}` has a level already, under its other spelling"));
            errors.push(error.help("write it once, with or without `ceid::`"));
            continue;
        }
        match setting(value) {
            Ok((level, priority)) => {
                overrides.push(LevelOverride { name, level, priority, source: LevelSource::File(place) });
            }
            Err(error) => errors.push(error),
        }
    }
    ConfigError::all(errors).map_or(Ok(overrides), Err)
}

/// A level, and how strong it is.
fn setting(value: Value<'_>) -> Result<(Level, i64), ConfigError> {
    if !value.is_table() {
        return Ok((level(value)?, 0));
    }
    let setting = value.table("a level")?;
    setting.only(&["level", "priority"])?;
    let priority = setting.get("priority").map_or(Ok(0), Value::integer)?;
    Ok((level(setting.required("level", "\"warn\"")?)?, priority))
}

fn level(value: Value<'_>) -> Result<Level, ConfigError> {
    let levels = [Level::Allow, Level::Warn, Level::Deny, Level::Forbid];
    value.choice(&levels.map(|level| (level.name(), level)))
}

#[cfg(test)]
mod tests;
