//! Compares what was found with the baselines that lie beside it: which findings are known, and which entries were looked for.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

use super::Report;
use crate::baseline::{self, Comparison, Counts, FILE_NAME, Key, keys};
use crate::config::{Config, ConfigError, Place};
use crate::diagnostic::{Diagnostic, Level};
use crate::project::{Package, Project};
use crate::rules;
use crate::source::{DiskSource, FileId, ReadError, ReadSource, SourceMap, Span};

/// Which baseline a run is compared with.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum BaselineChoice {
    /// That beside the manifest of each workspace, where there is one.
    #[default]
    Beside,
    /// This file, which has to be there.
    File(PathBuf),
    /// That beside the manifest, or this file, which will be written if it is not there.
    ToWrite(Option<PathBuf>),
    /// None.
    Ignored,
}

/// A crate as far as it was looked at.
#[derive(Clone, Debug)]
pub struct CheckedCrate {
    /// Index into the project's packages.
    pub package: usize,
    /// The files of its modules.
    pub files: BTreeSet<FileId>,
    /// The names of items and methods that are not there under this `cfg`.
    pub removed: BTreeSet<String>,
}

/// A workspace with its baseline.
struct Scope {
    /// What the paths of the baseline are relative to.
    root: PathBuf,
    comparison: Comparison,
}

/// Marks what is known, and keeps the comparisons in the report.
///
/// # Errors
/// If a baseline is missing that was named, or is not one.
pub(super) fn compare(
    project: &Project,
    config: &Config,
    choice: &BaselineChoice,
    report: &mut Report,
) -> Result<(), ConfigError> {
    let mut scopes = scopes(project, choice)?;
    let scope_of = |package: usize| {
        let package = project.packages.get(package)?;
        let is_single = !matches!(choice, BaselineChoice::Beside | BaselineChoice::ToWrite(None));
        scopes.iter().position(|scope| is_single || scope.root == package.workspace_root)
    };
    let owners: Vec<Option<usize>> = report.diagnostics.iter().map(|finding| scope_of(finding.package)).collect();
    let mut diagnostics = std::mem::take(&mut report.diagnostics);
    for (number, scope) in scopes.iter_mut().enumerate() {
        let own = diagnostics.iter_mut().zip(&owners).filter(|(_, owner)| **owner == Some(number));
        let findings: Vec<(&mut Diagnostic, Vec<Key>)> = own
            .map(|(finding, _)| (keys_of(report, &scope.root, finding), finding))
            .map(|(keys, it)| (it, keys))
            .collect();
        scope.comparison.mark(findings);
        let coverage = Coverage::of(project, config, report, &scope.root);
        let old = scope.comparison.old.iter().flatten();
        scope.comparison.checked = old.map(|(key, _)| key).filter(|key| coverage.holds(key)).cloned().collect();
    }
    report.diagnostics = diagnostics;
    mark_pairs(report);
    report.baselines = scopes.into_iter().map(|scope| scope.comparison).collect();
    Ok(())
}

/// Whether there is a baseline to compare with.
///
/// # Errors
/// As [`compare`].
pub(super) fn is_there(project: &Project, choice: &BaselineChoice) -> Result<bool, ConfigError> {
    Ok(!scopes(project, choice)?.is_empty())
}

fn scopes(project: &Project, choice: &BaselineChoice) -> Result<Vec<Scope>, ConfigError> {
    let reported = project.packages.iter().filter(|it| it.is_reported && !it.manifest_path.as_os_str().is_empty());
    let roots: BTreeSet<&Path> = reported.map(|package| package.workspace_root.as_path()).collect();
    // Several workspaces that share one named file are told apart by their directories.
    let common = if roots.len() == 1 { roots.iter().next().copied() } else { None }.unwrap_or(&project.root);
    let wanted: Vec<(&Path, PathBuf, bool)> = match choice {
        BaselineChoice::Ignored => Vec::new(),
        BaselineChoice::Beside => roots.iter().map(|root| (*root, root.join(FILE_NAME), true)).collect(),
        BaselineChoice::ToWrite(None) => roots.iter().map(|root| (*root, root.join(FILE_NAME), true)).collect(),
        BaselineChoice::ToWrite(Some(path)) => vec![(common, path.clone(), true)],
        BaselineChoice::File(path) => vec![(common, path.clone(), false)],
    };
    let is_kept_without_file = matches!(choice, BaselineChoice::ToWrite(_));
    let mut scopes = Vec::new();
    for (root, path, may_be_missing) in wanted {
        let old = load(&path, may_be_missing)?;
        if old.is_some() || is_kept_without_file {
            scopes.push(Scope { root: root.to_owned(), comparison: Comparison::new(path, old) });
        }
    }
    Ok(scopes)
}

fn load(path: &Path, may_be_missing: bool) -> Result<Option<Counts>, ConfigError> {
    match DiskSource.read(path) {
        Ok(text) => baseline::read(path, &text).map(Some),
        Err(ReadError::NotFound) if may_be_missing => Ok(None),
        Err(error) => {
            let is_missing = error == ReadError::NotFound;
            let place = Place { path: path.to_owned(), line: 1, column: 1, range: 0..0 };
            let error = ConfigError::at(place, format!("cannot read the baseline: {error}"));
            Err(if is_missing { error.help("`cargo ceid-lint baseline --baseline FILE` writes it") } else { error })
        }
    }
}

/// Under which names a finding is counted: those of its cycle, which stays where it is when a path through it changes.
fn keys_of(report: &Report, root: &Path, finding: &Diagnostic) -> Vec<Key> {
    let place = finding.facts.cycle.unwrap_or(finding.primary.span);
    let function = report.functions.around(place).map_or("", |function| &function.path);
    keys(finding, &relative(root, &report.sources.file(place.file).path), function)
}

/// The path from the root, with `/`, and `..` for what lies beside it.
fn relative(root: &Path, path: &Path) -> String {
    let shared = root.components().zip(path.components()).take_while(|(one, other)| one == other).count();
    // On another drive there is no way from here to there.
    if shared == 0 {
        return path.to_string_lossy().replace('\\', "/");
    }
    let up = root.components().skip(shared).map(|_| Component::ParentDir);
    let relative: PathBuf = up.chain(path.components().skip(shared)).collect();
    relative.to_string_lossy().replace('\\', "/")
}

/// What a run has looked at.
struct Coverage<'a> {
    project: &'a Project,
    config: &'a Config,
    report: &'a Report,
    root: &'a Path,
    /// The files that were looked at, by their paths from the root.
    files: BTreeMap<String, FileId>,
    /// Whether something could not be read, so that nothing can be told to be gone.
    is_partial: bool,
}

impl<'a> Coverage<'a> {
    fn of(project: &'a Project, config: &'a Config, report: &'a Report, root: &'a Path) -> Self {
        let ids: BTreeSet<FileId> = report.checked.iter().flat_map(|krate| &krate.files).copied().collect();
        let is_seen = |id: &FileId| {
            let path = &report.sources.file(*id).path;
            project.is_wanted(path) && !config.is_excluded(path)
        };
        let name = |id: FileId| (relative(root, &report.sources.file(id).path), id);
        let is_partial = !report.problems.is_empty() || project.problems.iter().any(|problem| problem.is_error);
        Self { project, config, report, root, files: ids.into_iter().filter(is_seen).map(name).collect(), is_partial }
    }

    /// Whether a finding of that name would have been found.
    fn holds(&self, key: &Key) -> bool {
        if self.is_partial {
            return false;
        }
        let Some(file) = self.files.get(&key.file) else {
            return self.holds_unparsed_file(key) || self.holds_removed_file(&key.file);
        };
        let crates: Vec<&CheckedCrate> =
            self.report.checked.iter().filter(|krate| krate.files.contains(file)).collect();
        let is_whole = |package: &Package| !package.is_partly_read && self.is_asked_for(key.rule, package);
        let mut packages = crates.iter().filter_map(|krate| self.project.packages.get(krate.package));
        // A name that is not there under this `cfg` may be that of the function, or of another one of the same path.
        let mut words = key.function.split(|letter: char| !letter.is_alphanumeric() && letter != '_');
        packages.all(is_whole)
            && !words.any(|word| crates.iter().any(|krate| krate.removed.contains(word)))
            && !self.depends_on_build(*file, &key.function)
    }

    /// Whether a file belongs to a package that was not parsed because nothing in it can be a filter.
    fn holds_unparsed_file(&self, key: &Key) -> bool {
        let path = self.root.join(&key.file);
        let Some(number) = self.project.owner(&path).filter(|number| self.report.unparsed.contains(number)) else {
            return false;
        };
        let package = &self.project.packages[number];
        let is_whole = package.is_reported && !package.is_partly_read && self.is_asked_for(key.rule, package);
        is_whole && self.project.is_wanted(&path) && !self.config.is_excluded(&path)
    }

    fn is_asked_for(&self, rule: &str, package: &Package) -> bool {
        rules::find(rule).is_some_and(|rule| rules::level_of(rule, self.config, package).level > Level::Allow)
    }

    /// Whether the code of a function is another one under other features or for another target.
    fn depends_on_build(&self, file: FileId, function: &str) -> bool {
        let sources: &SourceMap = &self.report.sources;
        let mut places = self.report.functions.of_file(file).iter().filter(|it| it.path == function);
        let is_conditional = |span: Span| {
            let mut conditions =
                sources.snippet(span).split("cfg").skip(1).map(|rest| rest.lines().next().unwrap_or(""));
            conditions.any(|rest| ["feature", "target", "unix", "windows"].iter().any(|word| rest.contains(word)))
        };
        places.any(|place| is_conditional(place.span))
    }

    /// Whether a file that is no longer there belonged to a package of which all was looked at.
    fn holds_removed_file(&self, file: &str) -> bool {
        let path = self.root.join(file);
        if path.exists() || !self.project.is_wanted(&path) {
            return false;
        }
        let manifest = path.ancestors().skip(1).map(|above| above.join("Cargo.toml")).find(|path| path.is_file());
        manifest.is_some_and(|manifest| {
            self.project
                .packages
                .iter()
                .any(|package| package.is_reported && !package.is_partly_read && package.manifest_path == manifest)
        })
    }
}

/// Marks the pairs on which something was found that is known, and nothing that is shown.
fn mark_pairs(report: &mut Report) {
    let mut by_cycle: BTreeMap<Span, Vec<&Diagnostic>> = BTreeMap::new();
    for finding in report.diagnostics.iter().filter(|finding| finding.suppressed.is_none()) {
        if let Some(head) = finding.facts.cycle {
            by_cycle.entry(head).or_default().push(finding);
        }
    }
    for cycle in &mut report.cycles {
        let found = by_cycle.get(&cycle.head).map_or(&[][..], Vec::as_slice);
        for pair in &mut cycle.filters {
            let mut about = found.iter().filter(|finding| super::names(finding, pair)).peekable();
            pair.known = about.peek().is_some() && about.all(|finding| finding.known);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_those_from_the_root() {
        assert_eq!(relative(Path::new("/ws"), Path::new("/ws/arm/src/lib.rs")), "arm/src/lib.rs");
        assert_eq!(relative(Path::new("/ws/a"), Path::new("/ws/b/src/lib.rs")), "../b/src/lib.rs");
        assert_eq!(relative(Path::new("/ws"), Path::new("/ws/my arm/ü.rs")), "my arm/ü.rs");
    }
}
