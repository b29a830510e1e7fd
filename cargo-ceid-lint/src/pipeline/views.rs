//! Packages that see the filters of other crates as the rest of the project does not: what `[package.metadata.ceid-lint]` says of them
//! holds for that package alone.

use crate::config::{Config, Scope, Section};
use crate::project::Project;

/// The project once for each package that sees other crates in its own way, and once for all others: the one that is reported, and
/// the configuration that holds for it. None if all packages see the same.
///
/// A type has one law in one analysis, so that two laws take two analyses.
pub(super) fn of(project: &Project, config: &Config) -> Vec<(Project, Config)> {
    let reported: Vec<usize> =
        (0..project.packages.len()).filter(|package| project.packages[*package].is_reported).collect();
    let has_own = |package: usize| {
        let manifest = &project.packages[package].manifest_path;
        config.sections.iter().any(|section| section.scope == Scope::Package(manifest.clone()) && is_far(section))
    };
    let (own, others): (Vec<usize>, Vec<usize>) = reported.into_iter().partition(|package| has_own(*package));
    if own.is_empty() || own.len() + others.len() < 2 {
        return Vec::new();
    }
    let alone = own.into_iter().map(|package| vec![package]);
    let views = alone.chain((!others.is_empty()).then_some(others));
    views.map(|packages| view(project, config, &packages)).collect()
}

fn view(project: &Project, config: &Config, packages: &[usize]) -> (Project, Config) {
    let (mut project, mut config) = (project.clone(), config.clone());
    for (number, package) in project.packages.iter_mut().enumerate() {
        package.is_reported &= packages.contains(&number);
    }
    let is_seen = |section: &Section| match &section.scope {
        Scope::Workspace(_) => true,
        Scope::Package(manifest) => {
            packages.iter().any(|package| project.packages[*package].manifest_path == *manifest)
        }
    };
    // What others say of their own types holds wherever these are used.
    for section in config.sections.iter_mut().filter(|section| !is_seen(section)) {
        section.filters.retain(|entry| is_near(&entry.target.path().text));
        section.guards.retain(|entry| is_near(&entry.guard_type.text));
    }
    (project, config)
}

/// Whether a section says something of other crates.
fn is_far(section: &Section) -> bool {
    section.presets.is_some()
        || section.filters.iter().any(|entry| !is_near(&entry.target.path().text))
        || section.guards.iter().any(|entry| !is_near(&entry.guard_type.text))
}

/// Whether a path leads into the package that its entry belongs to.
fn is_near(path: &str) -> bool {
    path.starts_with("crate::")
}
