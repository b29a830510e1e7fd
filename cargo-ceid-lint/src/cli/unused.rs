//! What the configuration asks for and this version does not do yet: nothing that was asked for is dropped in silence.

use super::Console;
use crate::config::{
    Config, FilterEntry, FilterTarget, InstancePlace, Multiplicity, OnErr, Receiver, Section, TimeBase,
};
use crate::project::Project;

/// Names the keys of each file that change nothing.
pub(super) fn warn(project: &Project, config: &Config, console: Console) {
    for section in &config.sections {
        let keys = keys(section);
        if keys.is_empty() || console.is_quiet() {
            continue;
        }
        let file = section.path.strip_prefix(&project.root).unwrap_or(&section.path);
        let list = keys.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", ");
        let them = if keys.len() == 1 { "it" } else { "them" };
        console.warn(&format!("this version reads {list} in `{}`, and does not use {them} yet", file.display()));
    }
}

fn keys(section: &Section) -> Vec<&'static str> {
    let mut keys: Vec<&str> = section.filters.iter().flat_map(keys_of_filter).collect();
    keys.sort_unstable();
    keys.dedup();
    let tables = [
        ("[[cycle]]", section.cycles.is_empty()),
        ("[[guard]]", section.guards.is_empty()),
        ("presets", section.presets.is_none()),
    ];
    keys.extend(tables.into_iter().filter(|(_, is_empty)| !is_empty).map(|(name, _)| name));
    keys
}

fn keys_of_filter(entry: &FilterEntry) -> impl Iterator<Item = &'static str> {
    let keys = [
        ("filter.function", matches!(entry.target, FilterTarget::Function(_))),
        ("filter.multiplicity", entry.multiplicity.iter().any(|halves| *halves != Multiplicity::Once)),
        ("filter.instance", entry.instance != InstancePlace::Receiver),
        ("filter.key", !entry.key.is_empty()),
        ("filter.receiver", entry.receiver != Receiver::Exclusive),
        ("filter.on_err", entry.on_err != OnErr::Updated),
        ("filter.time_base", entry.time_base != TimeBase::Fixed),
    ];
    keys.into_iter().filter(|(_, is_unused)| *is_unused).map(|(key, _)| key)
}
