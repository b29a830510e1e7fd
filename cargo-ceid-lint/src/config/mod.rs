//! What the user configured: `ceid-lint.toml`, `[workspace.metadata.ceid-lint]`, `[package.metadata.ceid-lint]` and the levels
//! of the command line. Holds names as they were written, each with its place; what they mean is decided where they are used.

mod entries;
mod error;
pub mod glob;
mod levels;
mod load;
mod presets;
pub(crate) mod reader;
pub mod spelling;

use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use entries::{
    CycleEntry, CycleTarget, FilterEntry, FilterKind, FilterTarget, GuardEntry, InstancePlace, Multiplicity, OnErr,
    Receiver, TimeBase, Word,
};
pub use error::{ConfigError, Place};
pub use levels::{LevelOverride, LevelOverrides, LevelSource};
pub use load::{FILE_NAME, KEYS, Scope, load};
pub use presets::{PRESETS, Preset, active_presets};

/// All configuration of a run.
#[derive(Clone, Debug, Default)]
pub struct Config {
    /// The sections that were found: those of workspaces before those of packages.
    pub sections: Vec<Section>,
    /// The levels of the command line, stronger than all sections.
    pub overrides: LevelOverrides,
}

impl Config {
    /// The sections that hold for a package, the weakest first.
    pub fn sections_of<'a>(
        &'a self,
        workspace_root: &'a Path,
        manifest: &'a Path,
    ) -> impl Iterator<Item = &'a Section> {
        self.sections.iter().filter(move |section| match &section.scope {
            Scope::Workspace(root) => root == workspace_root,
            Scope::Package(own) => own == manifest,
        })
    }

    /// Whether a section excludes the file at `path`.
    #[must_use]
    pub fn is_excluded(&self, path: &Path) -> bool {
        self.sections.iter().any(|section| {
            let Ok(relative) = path.strip_prefix(section.directory()) else { return false };
            let relative = relative.to_string_lossy().replace('\\', "/");
            section.exclude.iter().any(|pattern| {
                let directory = format!("{}/**", pattern.trim_end_matches('/'));
                glob::matches(pattern, &relative) || glob::matches(&directory, &relative)
            })
        })
    }
}

/// One table of configuration.
#[derive(Clone, Debug)]
pub struct Section {
    /// What it holds for.
    pub scope: Scope,
    /// The file it was read from.
    pub path: PathBuf,
    /// The text of that file, so that a path that names nothing can be shown in it.
    pub text: Arc<str>,
    /// Which presets are active.
    pub presets: Option<Presets>,
    /// Patterns of files that are not reported, relative to the directory of the manifest.
    pub exclude: Vec<String>,
    /// Levels of rules and groups.
    pub lints: Vec<LevelOverride>,
    /// Filter types beyond those of the trait.
    pub filters: Vec<FilterEntry>,
    /// Cycle functions that a framework calls.
    pub cycles: Vec<CycleEntry>,
    /// Guard types beyond `ceid_core`'s.
    pub guards: Vec<GuardEntry>,
}

impl Section {
    /// The directory that its patterns are relative to.
    #[must_use]
    pub fn directory(&self) -> &Path {
        match &self.scope {
            Scope::Workspace(root) => root,
            Scope::Package(manifest) => manifest.parent().unwrap_or(Path::new("")),
        }
    }
}

/// Which presets are active.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Presets {
    /// Those of the crates in the dependency graph.
    Auto,
    /// None.
    None,
    /// These.
    Named(Vec<(String, Place)>),
}
