//! What the entries of the configuration come to in code that is analysed in parts. Never resolves a path itself.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::left_out;
use crate::config::{Config, ConfigError, CycleTarget, Preset, Scope, Section, Word};
use crate::index::{CrateId, EntryScope, Index, Namespace};
use crate::project::{Package, Project};
use crate::source::ReadSource;

/// Which entries named something in some part.
#[derive(Debug)]
pub(super) struct Ledger(Vec<Vec<bool>>);

impl Ledger {
    pub(super) fn of(config: &Config) -> Self {
        let count = |section: &Section| section.filters.len() + section.cycles.len() + section.guards.len();
        Self(config.sections.iter().map(|section| vec![false; count(section)]).collect())
    }

    /// Takes down which entries named something in a part.
    pub(super) fn add(&mut self, named: &[(usize, Vec<bool>)]) {
        for (section, own) in named {
            for (entry, is_named) in self.0[*section].iter_mut().zip(own) {
                *entry |= is_named;
            }
        }
    }

    /// Whether every entry named something.
    pub(super) fn is_complete(&self) -> bool {
        self.0.iter().flatten().all(|entry| *entry)
    }
}

/// The paths that entries name in crates whose sources are perhaps not read.
pub(super) fn paths_outside(config: &Config, presets: &[Preset]) -> Vec<String> {
    let filters = config.sections.iter().flat_map(|section| &section.filters);
    let cycles = config.sections.iter().flat_map(|section| &section.cycles);
    let guards = config.sections.iter().flat_map(|section| &section.guards);
    let filters = filters.chain(presets.iter().flat_map(|preset| &preset.filters));
    let cycles = cycles.chain(presets.iter().flat_map(|preset| &preset.cycles));
    let methods = cycles.map(|entry| entry.target.path().text.as_str());
    let methods = methods.map(|path| path.rsplit_once("::").map_or(path, |(of, _)| of));
    filters
        .map(|entry| entry.target.path().text.as_str())
        .chain(guards.map(|entry| entry.guard_type.text.as_str()))
        .chain(methods)
        .filter(|path| !path.starts_with("crate::"))
        .map(str::to_owned)
        .collect()
}

/// The packages of the dependency graph, as code that holds some of the packages sees them: the others have sources that are
/// read, though not here.
pub(super) fn graph_around(project: &Project, packages: &[usize]) -> BTreeSet<String> {
    let mut graph = project.graph.clone();
    let elsewhere = (0..project.packages.len()).filter(|package| !packages.contains(package));
    for package in elsewhere.map(|package| &project.packages[package]).filter(|package| !package.targets.is_empty()) {
        graph.remove(&package.name);
    }
    graph
}

/// Makes filters, cycles and guards of what the entries name in this part of the code; answers which ones named something,
/// by the numbers of their sections.
///
/// # Errors
/// If an entry names what it cannot name.
pub(super) fn add_some(
    project: &Project,
    config: &Config,
    graph: &BTreeSet<String>,
    index: &mut Index,
    is_partial: bool,
) -> Result<Vec<(usize, Vec<bool>)>, ConfigError> {
    let mut named = Vec::new();
    for (number, section) in config.sections.iter().enumerate() {
        let scope = section_scope(project, graph, index, (number, section), is_partial);
        if scope.crates.is_empty() {
            continue;
        }
        let mut own = Vec::new();
        for (added, is_wrong) in outcomes(index, &scope, section) {
            match added {
                Err(error) if is_wrong => return Err(error),
                added => own.push(added.is_ok()),
            }
        }
        named.push((number, own));
    }
    Ok(named)
}

/// Makes filters, cycles and guards of what the entries name.
///
/// # Errors
/// If entries name nothing: all that is wrong.
pub(super) fn add_all(
    project: &Project,
    config: &Config,
    index: &mut Index,
    is_partial: bool,
    source: &dyn ReadSource,
) -> Result<(), ConfigError> {
    let mut errors = Vec::new();
    for (number, section) in config.sections.iter().enumerate() {
        let scope = section_scope(project, &project.graph, index, (number, section), is_partial);
        let roots = packages_of(project, section).flat_map(|package| &package.roots_left_out);
        let roots: Vec<&Path> = roots.map(PathBuf::as_path).collect();
        let filters = section.filters.iter().map(|entry| entry.target.path());
        let cycles = section.cycles.iter().map(|entry| entry.target.path());
        let words = filters.chain(cycles).chain(section.guards.iter().map(|entry| &entry.guard_type));
        let words: Vec<&Word> = words.collect();
        for ((added, is_wrong), word) in outcomes(index, &scope, section).into_iter().zip(words) {
            if let Err(error) = added
                && (is_wrong || !left_out::define(&roots, &word.text, source))
            {
                errors.push(error.in_text(&section.text));
            }
        }
    }
    ConfigError::all(errors).map_or(Ok(()), Err)
}

fn packages_of<'a>(project: &'a Project, section: &'a Section) -> impl Iterator<Item = &'a Package> {
    project.packages.iter().filter(|package| match &section.scope {
        Scope::Workspace(root) => package.workspace_root == *root,
        Scope::Package(manifest) => package.manifest_path == *manifest,
    })
}

/// Makes filters and cycles of the entries of presets, where the configuration says nothing of them.
///
/// # Errors
/// If an entry is wrong, which the tests rule out.
pub(super) fn add_presets(presets: &[Preset], graph: &BTreeSet<String>, index: &mut Index) -> Result<(), ConfigError> {
    let scope = scope_of(graph, index, true, |_| true);
    for preset in presets {
        for entry in &preset.filters {
            index.add_preset_filter(&scope, entry);
        }
        for entry in &preset.cycles {
            index.add_cycle(&scope, entry)?;
        }
    }
    index.find_holders();
    Ok(())
}

/// What comes of each entry, and whether an error is about something that is there.
fn outcomes(index: &mut Index, scope: &EntryScope<'_>, section: &Section) -> Vec<(Result<(), ConfigError>, bool)> {
    let mut outcomes = Vec::new();
    let is_there = |index: &Index, path: &str| {
        [Namespace::Type, Namespace::Value].iter().any(|space| !index.named_by(scope, path, *space).is_empty())
    };
    for entry in &section.filters {
        let added = index.add_filter(scope, entry);
        let is_wrong = added.is_err() && is_there(index, &entry.target.path().text);
        outcomes.push((added, is_wrong));
    }
    for (entry, (added, is_wrong)) in section.filters.iter().zip(&mut outcomes) {
        if added.is_ok()
            && let Err(error) = index.check_one_law(scope, entry)
        {
            (*added, *is_wrong) = (Err(error), true);
        }
    }
    for entry in &section.cycles {
        let added = index.add_cycle(scope, entry);
        let path = &entry.target.path().text;
        let is_wrong = match &entry.target {
            _ if added.is_ok() => false,
            CycleTarget::Attribute(_) => false,
            CycleTarget::Function(_) => is_there(index, path),
            CycleTarget::Method(_) => path.rsplit_once("::").is_some_and(|(of, _)| is_there(index, of)),
        };
        outcomes.push((added, is_wrong));
    }
    for entry in &section.guards {
        let added = index.add_guard(scope, entry);
        let is_wrong = added.is_err() && is_there(index, &entry.guard_type.text);
        outcomes.push((added, is_wrong));
    }
    outcomes
}

fn section_scope<'a>(
    project: &Project,
    graph: &'a BTreeSet<String>,
    index: &Index,
    (number, section): (usize, &Section),
    is_partial: bool,
) -> EntryScope<'a> {
    let in_scope = |package: usize| {
        let package = &project.packages[package];
        match &section.scope {
            Scope::Workspace(root) => package.workspace_root == *root,
            Scope::Package(manifest) => package.manifest_path == *manifest,
        }
    };
    let is_partial =
        is_partial || (0..project.packages.len()).any(|at| in_scope(at) && project.packages[at].is_partly_read);
    EntryScope { section: number, ..scope_of(graph, index, is_partial, in_scope) }
}

pub(super) fn scope_of<'a>(
    graph: &'a BTreeSet<String>,
    index: &Index,
    is_partial: bool,
    in_scope: impl Fn(usize) -> bool,
) -> EntryScope<'a> {
    let crates = (0u32..).zip(&index.crates).filter(|(_, krate)| in_scope(krate.package));
    EntryScope { crates: crates.map(|(number, _)| CrateId(number)).collect(), graph, is_partial, section: 0 }
}
