//! The profiles of cargo: those it has by itself, and those that a workspace or cargo's configuration defines.

use std::env;
use std::path::Path;

use super::LoadError;
use crate::config::spelling::nearest;

/// The profiles that need no definition.
const BUILT_IN: [&str; 4] = ["dev", "release", "test", "bench"];

/// Refuses a profile that is defined nowhere, as cargo does; `tables` are cargo's configuration.
pub(super) fn check(name: Option<&str>, root: &Path, tables: &[toml::Table]) -> Result<(), LoadError> {
    let Some(name) = name.filter(|name| !BUILT_IN.contains(name)) else { return Ok(()) };
    let variable = format!("CARGO_PROFILE_{}_", name.to_uppercase().replace('-', "_"));
    let is_in_environment = || env::vars_os().any(|(key, _)| key.to_string_lossy().starts_with(&variable));
    let manifest = std::fs::read_to_string(root.join("Cargo.toml")).ok().and_then(|text| text.parse().ok());
    let tables: Vec<&toml::Table> = tables.iter().chain(&manifest).collect();
    let profiles = tables.iter().filter_map(|table| table.get("profile")?.as_table()).flat_map(|table| table.keys());
    let known: Vec<&str> = profiles.map(String::as_str).collect();
    if known.contains(&name) || is_in_environment() {
        return Ok(());
    }
    let error = LoadError::new(format!("profile `{name}` is not defined"));
    Err(error.similar("profile", nearest(name, BUILT_IN.into_iter().chain(known))))
}
