//! Loads a project: the workspace of a manifest, or the packages and files that paths lead to.

use std::path::{Path, PathBuf};

use super::cargo_config::CargoConfig;
use super::toolchain::{self, Failure};
use super::workspace::{Workspace, normalized};
use super::{
    LoadError, Project, Selection, assemble, cargo_config, cfg, features, loose, manifest, metadata, profile, select,
};
use crate::config;
use crate::diagnostic::Problem;

/// Loads what the user selected.
///
/// # Errors
/// If there is no manifest, if it is wrong, or if the selection names something that does not exist.
pub fn load(selection: &Selection) -> Result<Project, LoadError> {
    if selection.paths.is_empty() {
        return load_workspace(&manifest_of(selection)?, selection, &[]);
    }
    let mut roots = loose::find(selection)?;
    if let Some(path) = &selection.manifest_path {
        roots.manifests = [existing(path, selection)?].into();
        roots.files.clear();
    }
    load_roots(&roots, selection)
}

/// Loads a workspace without asking cargo how its dependencies are resolved, which takes long and matters only where there is
/// something to check. Packages of which only that can tell what their code is are marked: where one of them is to be analysed,
/// the project has to be loaded. `None` if that has to be done in any case.
#[must_use]
pub fn load_unresolved(selection: &Selection) -> Option<Project> {
    let path = manifest_of(selection).ok().filter(|path| selection.paths.is_empty() && path.to_str().is_some())?;
    let lock = metadata::lock_of_members(&path, selection)?;
    let run_in = directory_of_cargo(&path, selection);
    let config = cargo_config::read(run_in, &selection.cargo_options, selection.target.as_deref());
    let ask = || metadata::load_unresolved(&lock, &path, run_in, selection);
    let (target, workspace) = beside_rustc(run_in, selection, &config, ask);
    let workspace = workspace?;
    let mut notices: Vec<String> = target.notice.into_iter().collect();
    let mut project = select_in(&workspace, selection, &[], &target.cfg, &mut notices).ok()?;
    // What there is to say is said of the whole.
    if !notices.is_empty() {
        return None;
    }
    for (package, found) in project.packages.iter_mut().zip(&workspace.packages) {
        package.is_unresolved = found.asks_cargo();
    }
    Some(project)
}

impl Selection {
    /// The directory in which most of the code lies, as far as that can be told before cargo was asked.
    #[must_use]
    pub fn likely_root(&self) -> Option<PathBuf> {
        let manifest = if self.paths.is_empty() { manifest_of(self).ok()? } else { return None };
        manifest.parent().map(Path::to_owned)
    }
}

fn manifest_of(selection: &Selection) -> Result<PathBuf, LoadError> {
    if let Some(path) = &selection.manifest_path {
        return existing(path, selection);
    }
    manifest::nearest(&selection.current_dir).ok_or_else(|| {
        let directory = selection.current_dir.display();
        LoadError::new(format!("could not find `Cargo.toml` in `{directory}` or any parent directory"))
            .help("name a file or a directory: `cargo ceid-lint .` checks every package below this one")
    })
}

fn existing(path: &Path, selection: &Selection) -> Result<PathBuf, LoadError> {
    let absolute = normalized(&selection.current_dir.join(path));
    if absolute.is_file() {
        return Ok(absolute);
    }
    let shown = path.display();
    Err(if absolute.is_dir() {
        LoadError::new(format!("manifest path `{shown}` is a directory, and a file is expected"))
            .help(format!("did you mean `{}`?", path.join("Cargo.toml").display()))
    } else {
        LoadError::new(format!("manifest path `{shown}` does not exist"))
    })
}

fn load_roots(roots: &loose::Roots, selection: &Selection) -> Result<Project, LoadError> {
    let is_alone = roots.manifests.len() + roots.files.len() == 1;
    let mut parts: Vec<Project> = Vec::new();
    let mut problems = roots.problems.clone();
    let mut unread: Vec<&Path> = Vec::new();
    for path in &roots.manifests {
        if parts
            .iter()
            .any(|part| part.packages.iter().any(|package| package.manifest_path == *path && package.is_reported))
        {
            continue;
        }
        match load_workspace(path, selection, &roots.only) {
            Ok(part) => parts.push(part),
            Err(error) if is_alone => return Err(error),
            Err(error) => {
                problems.push(error.problem(path));
                unread.extend(path.parent());
            }
        }
    }
    parts.extend(load_files(roots, selection)?);
    let mut project = merge(parts);
    // Paths are told as if all of them had been read.
    if !project.packages.is_empty() {
        project.root = unread.iter().fold(project.root, |root, path| common(&root, path));
    }
    project.only = roots.only.clone();
    project.problems.extend(problems);
    Ok(project)
}

fn load_workspace(path: &Path, selection: &Selection, only: &[PathBuf]) -> Result<Project, LoadError> {
    if path.to_str().is_none() {
        return Err(LoadError::new(format!(
            "the path `{}` is not valid UTF-8, and cargo loads no manifest there",
            path.display()
        ))
        .help("rename the directory, or name its files: `cargo ceid-lint src/main.rs`"));
    }
    let run_in = directory_of_cargo(path, selection);
    let config = cargo_config::read(run_in, &selection.cargo_options, selection.target.as_deref());
    let (mut notices, mut problems) = (Vec::new(), Vec::new());
    let ask = |triple: Option<&str>| {
        let mut notices = Vec::new();
        (metadata::load(path, run_in, selection, triple, &mut notices), notices)
    };
    let guess = config.target.clone().unwrap_or_else(toolchain::host);
    let (target, mut loaded) = beside_rustc(run_in, selection, &config, || ask(Some(&guess)));
    if target.triple.as_ref() != Some(&guess) && metadata::depends_on_target(path) {
        loaded = ask(target.triple.as_deref());
    }
    let (loaded, told) = loaded;
    notices.extend(told);
    let mut workspace = match loaded {
        Ok(workspace) => workspace,
        Err(failure) => {
            about_a_flag(&failure, selection)?;
            without_cargo(path, &failure, &mut notices, &mut problems)?
        }
    };
    let profiles = cargo_config::tables(run_in, &selection.cargo_options);
    profile::check(selection.profile.as_deref(), &workspace.root, &profiles)?;
    notices.extend(target.notice);
    if !workspace.is_resolved {
        // A path names the files that are reported, and leaves the features to its whole workspace.
        let selected = if only.is_empty() {
            select::packages(&workspace, selection, only, &mut Vec::new())?
        } else {
            (0..workspace.members).collect()
        };
        features::activate(&mut workspace, &selection.features, &selected)?;
    }
    let mut project = select_in(&workspace, selection, only, &target.cfg, &mut notices)?;
    project.notices = notices;
    project.problems.extend(problems);
    Ok(project)
}

/// The directory in which cargo is run, where it looks for its configuration.
fn directory_of_cargo<'a>(manifest: &'a Path, selection: &'a Selection) -> &'a Path {
    let directory = manifest.parent().unwrap_or(manifest);
    if selection.current_dir.starts_with(directory) || directory.starts_with(&selection.current_dir) {
        &selection.current_dir
    } else {
        directory
    }
}

/// Asks rustc what holds for the target, and cargo beside it.
fn beside_rustc<T: Send>(
    run_in: &Path,
    selection: &Selection,
    config: &CargoConfig,
    ask_cargo: impl FnOnce() -> T + Send,
) -> (cfg::TargetCfg, T) {
    std::thread::scope(|scope| {
        let answer = scope.spawn(ask_cargo);
        let target = cfg::read(run_in, config, selection.is_release());
        (target, answer.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    })
}

/// What cargo says against one of its flags that was handed on: no manifest is wrong then.
fn about_a_flag(failure: &Failure, selection: &Selection) -> Result<(), LoadError> {
    let Failure::Refused(text) = failure else { return Ok(()) };
    let mut flags = ["--config", "-Z"].into_iter().filter(|flag| selection.cargo_options.iter().any(|it| it == flag));
    let first = failure.first_line();
    let Some(flag) = flags.find(|flag| first.contains(flag)) else { return Ok(()) };
    let text = text.strip_prefix("error: ").unwrap_or(text);
    Err(LoadError::new(format!("cargo does not take `{flag}`: {text}"))
        .help(format!("correct `{flag}`, or leave it out; `cargo check` reports the same")))
}

/// Reads the manifests when cargo cannot be run, and when it refuses them while the sources can be found all the same: what cargo
/// says against them is then a problem beside the findings.
fn without_cargo(
    path: &Path,
    failure: &Failure,
    notices: &mut Vec<String>,
    problems: &mut Vec<Problem>,
) -> Result<Workspace, LoadError> {
    let refusal = match failure {
        Failure::Refused(text) if !text.contains("believes it's in a workspace when it's not") => {
            let text = text.strip_prefix("error: ").unwrap_or(text);
            let error = LoadError::new(format!("cargo cannot load `{}`: {text}", path.display()));
            Some(error.help("correct the manifest; `cargo check` reports the same"))
        }
        _ => None,
    };
    let read = manifest::read_workspace(path, problems);
    let Some(refusal) = refusal else {
        notices.push(format!("`cargo metadata` failed ({}); the manifests are read without it", failure.first_line()));
        return read;
    };
    match read {
        Ok(workspace) if workspace.packages.iter().any(|found| !found.targets.is_empty()) => {
            // A member that cannot be read, and a dependency that is not there, are told by themselves.
            if problems.is_empty() && !is_about_a_lost_dependency(&workspace, &refusal) {
                problems.push(refusal.problem(path));
            }
            Ok(workspace)
        }
        _ => Err(refusal),
    }
}

fn is_about_a_lost_dependency(workspace: &Workspace, refusal: &LoadError) -> bool {
    let mut paths = workspace.packages.iter().flat_map(|found| &found.dependencies).filter_map(|it| it.path.as_ref());
    paths.any(|path| {
        let manifest = path.join("Cargo.toml");
        !manifest.is_file() && refusal.message.contains(&format!("`{}`", manifest.display()))
    })
}

/// The project with files that none of its targets reads, each checked on its own.
///
/// # Errors
/// Never for files that are there.
pub fn with_files(project: Project, files: &[PathBuf], selection: &Selection) -> Result<Project, LoadError> {
    let only = project.only.clone();
    let roots = loose::Roots { files: files.iter().cloned().collect(), only: only.clone(), ..loose::Roots::default() };
    let mut parts = vec![project];
    parts.extend(load_files(&roots, selection)?);
    Ok(Project { only, ..merge(parts) })
}

/// One project for each file outside any package.
fn load_files(roots: &loose::Roots, selection: &Selection) -> Result<Vec<Project>, LoadError> {
    if roots.files.is_empty() {
        return Ok(Vec::new());
    }
    let in_part = |(at, file): &(usize, &PathBuf)| is_in_part(selection, *at, &file.to_string_lossy());
    let files = roots.files.iter().enumerate().filter(in_part);
    let texts = files.map(|(_, file)| (file, std::fs::read_to_string(file).unwrap_or_default()));
    let target = target_of(selection);
    texts.map(|(file, text)| load_file(file, &text, &roots.only, &target)).collect()
}

/// The project of one file outside any package, whose text is known.
///
/// # Errors
/// Never; all selections of one file hold it.
pub fn of_file(file: &Path, text: &str) -> Result<Project, LoadError> {
    load_file(file, text, &[], &target_of(&Selection::default()))
}

/// What the build context says where there is no package.
fn target_of(selection: &Selection) -> cfg::TargetCfg {
    let config = cargo_config::read(&selection.current_dir, &selection.cargo_options, selection.target.as_deref());
    cfg::read(&selection.current_dir, &config, selection.is_release())
}

fn load_file(file: &Path, text: &str, only: &[PathBuf], target: &cfg::TargetCfg) -> Result<Project, LoadError> {
    let everything = Selection { workspace: true, ..Selection::default() };
    let mut notices: Vec<String> = target.notice.clone().into_iter().collect();
    let mut project = select_in(&loose::package(file, text), &everything, only, &target.cfg, &mut notices)?;
    project.notices = notices;
    Ok(project)
}

fn is_in_part(selection: &Selection, at: usize, name: &str) -> bool {
    selection.partition.is_none_or(|part| part.holds(at, name))
}

fn select_in(
    workspace: &Workspace,
    selection: &Selection,
    only: &[PathBuf],
    cfg: &super::CfgValues,
    notices: &mut Vec<String>,
) -> Result<Project, LoadError> {
    let selected = select::packages(workspace, selection, only, notices)?.into_iter().enumerate();
    let selected = selected.filter(|(at, package)| is_in_part(selection, *at, &workspace.packages[*package].name));
    let packages: Vec<usize> = selected.map(|(_, package)| package).collect();
    let selected = select::targets(workspace, &packages, selection, only)?;
    for at in &packages {
        if !selected.iter().any(|(package, _)| package == at) {
            let name = &workspace.packages[*at].name;
            let targets = &workspace.packages[*at].targets;
            let is_optional = targets.iter().all(|target| !target.required_features.is_empty());
            let help = match is_optional && !targets.is_empty() {
                true => "all of its targets need features that are off; `--all-features` turns them on",
                false => "`--all-targets` takes all of them",
            };
            notices.push(format!("package `{name}` has no target that is selected; {help}"));
        }
    }
    let mut project = assemble::project(workspace, cfg, &selected);
    project.only = only.to_vec();
    notices.extend(misplaced_configurations(&project));
    Ok(project)
}

/// What there is to say of configuration files beside the manifests of members, which nothing reads.
fn misplaced_configurations(project: &Project) -> Vec<String> {
    let members = project.packages.iter().filter(|package| package.is_reported);
    let misplaced = members.filter_map(|package| {
        let directory = package.manifest_path.parent().filter(|directory| *directory != package.workspace_root)?;
        let path = directory.join(config::FILE_NAME);
        path.is_file().then_some((path, package))
    });
    let shown = |path: &Path| path.strip_prefix(&project.root).unwrap_or(path).display().to_string();
    misplaced
        .map(|(path, package)| {
            format!(
                "`{}` is not read: the configuration stands beside the manifest of the workspace, and that of one package in \
                 `[package.metadata.ceid-lint]` of `{}`",
                shown(&path),
                shown(&package.manifest_path)
            )
        })
        .collect()
}

/// Puts projects side by side. A package that several of them read is kept once, reported if one of them reports it.
fn merge(parts: Vec<Project>) -> Project {
    let mut parts = parts.into_iter();
    let Some(mut merged) = parts.next() else { return Project::default() };
    for part in parts {
        merged.root = common(&merged.root, &part.root);
        merged.graph.extend(part.graph);
        merged.problems.extend(part.problems);
        for notice in part.notices {
            if !merged.notices.contains(&notice) {
                merged.notices.push(notice);
            }
        }
        let places: Vec<usize> = (0..part.packages.len())
            .scan(merged.packages.len(), |next, at| {
                let package = &part.packages[at];
                let known = merged.packages.iter().position(|other| other.id == package.id);
                Some(known.unwrap_or_else(|| {
                    *next += 1;
                    *next - 1
                }))
            })
            .collect();
        for (mut package, place) in part.packages.into_iter().zip(&places) {
            for dependency in &mut package.dependencies {
                dependency.package = dependency.package.map(|at| places[at]);
            }
            if *place == merged.packages.len() {
                merged.packages.push(package);
            } else if package.is_reported && !merged.packages[*place].is_reported {
                merged.packages[*place] = package;
            }
        }
    }
    merged
}

fn common(a: &Path, b: &Path) -> PathBuf {
    a.components().zip(b.components()).take_while(|(a, b)| a == b).map(|(a, _)| a).collect()
}

#[cfg(test)]
pub(super) mod tests;
