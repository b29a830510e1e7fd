//! Parsed files: the module tree of a crate as our own [`tree`], `cfg` in three values, macros read as code. Never fails:
//! what cannot be read or parsed becomes a [`Problem`], and the rest goes on. Comments that are [`Directives`] are read beside.

pub mod tree;

mod bare_closures;
mod cfg_eval;
mod depth;
mod directives;
mod edition;
mod lex;
mod lower;
mod macros;
mod modules;
mod outline;
mod text;
mod ways_out;

#[cfg(test)]
mod tests;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::diagnostic::Problem;
use crate::parallel::with_large_stack;
use crate::project::CfgValues;
use crate::source::{FileId, FileSet, MemorySource, SourceMap};
pub use depth::{Excess, MAX_LINKS, MAX_NESTING, TooDeep, check_depth};
pub use directives::{CycleDirective, Directive, DirectiveKind, Directives, NearMiss, Site, Suppression};
pub(crate) use lex::{Lexer, Token, TokenKind};
pub use macros::{Exports, Neighbours, has_known_macros, spelled};
use modules::Loader;
pub use outline::{Enclosure, Outline};
pub(crate) use text::is_keyword;
use tree::{Attribute, Item};

/// A crate whose module tree was followed from its root.
#[derive(Clone, Debug)]
pub struct ParsedCrate {
    /// Index into the project's packages.
    pub package: usize,
    /// Index into the package's targets.
    pub target: usize,
    /// The items of the root module.
    pub items: Vec<Item>,
}

/// The root module of a crate.
#[derive(Clone, Debug, Default)]
pub struct RootModule {
    /// Its inner attributes: `#![allow(…)]`, `#![no_std]`.
    pub attributes: Vec<Attribute>,
    /// Its items.
    pub items: Vec<Item>,
    /// The macros among them that other crates may call.
    pub exports: Exports,
    /// Whether the crate as a whole is not there under this `cfg`: `#![cfg(target_os = "none")]`.
    pub is_absent: bool,
    /// The names of items and methods, of all its modules, that are not there under this `cfg`.
    pub removed: BTreeSet<String>,
    /// The files and directories of modules that are declared, and not there under this `cfg`.
    pub left_out: BTreeSet<PathBuf>,
    /// The files that its modules lie in, as far as they could be read.
    pub files: BTreeSet<FileId>,
}

/// The items of the crate with that root file, its modules included. Files are read through `files`, once each.
///
/// `edition` is "2015", "2018", "2021" or "2024": in "2015", every `use` path begins at the crate root, so that it gets the
/// empty first segment of a leading `::`.
pub fn parse_crate(
    root_file: &Path,
    edition: &str,
    cfg: &CfgValues,
    files: &mut FileSet,
    problems: &mut Vec<Problem>,
) -> Vec<Item> {
    parse_root(root_file, edition, cfg, &Neighbours::default(), files, problems).items
}

/// As [`parse_crate`], with the attributes of the crate, and with what it knows of the crates that it depends on.
pub fn parse_root(
    root_file: &Path,
    edition: &str,
    cfg: &CfgValues,
    neighbours: &Neighbours,
    files: &mut FileSet,
    problems: &mut Vec<Problem>,
) -> RootModule {
    deeply(|| Loader::new(cfg, edition, neighbours, files, problems).root(root_file))
}

/// As [`parse_root`], without any items: no more than the tree of one file is in memory at a time.
pub fn survey_root(
    root_file: &Path,
    edition: &str,
    cfg: &CfgValues,
    neighbours: &Neighbours,
    files: &mut FileSet,
    problems: &mut Vec<Problem>,
) -> RootModule {
    deeply(|| Loader::new(cfg, edition, neighbours, files, problems).without_items().root(root_file))
}

/// Parses a crate. Its tree has spans of its own: the parser's, with its copies of all texts, are done with.
fn deeply(parse: impl FnOnce() -> RootModule + Send) -> RootModule {
    with_large_stack(|| {
        let root = parse();
        proc_macro2::extra::invalidate_current_thread_spans();
        root
    })
}

/// The items of a text that is shown as `name`, with modules from nowhere: for tests of this floor and of those above it.
pub fn parse_source(name: &str, text: &str, cfg: &CfgValues, map: &mut SourceMap) -> (Vec<Item>, Vec<Problem>) {
    let mut source = MemorySource::default();
    source.insert(Path::new(name), Arc::from(text));
    let mut files = FileSet::new(std::mem::take(map), Arc::new(source));
    let mut problems = Vec::new();
    let items = parse_crate(Path::new(name), "2024", cfg, &mut files, &mut problems);
    *map = files.into_map();
    (items, problems)
}
