//! What the configuration asks for and this version does not do yet: nothing that was asked for is dropped in silence.

use super::Console;
use crate::config::{Config, Section};
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
    let tables = [
        ("[[cycle]]", section.cycles.is_empty()),
        ("[[guard]]", section.guards.is_empty()),
        ("presets", section.presets.is_none()),
    ];
    tables.into_iter().filter(|(_, is_empty)| !is_empty).map(|(name, _)| name).collect()
}
