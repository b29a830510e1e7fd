//! From a project to what a first configuration of it could name.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use super::entries::{self, paths_outside, scope_of};
use super::parse::{self, Part};
use crate::candidates::{self, Candidates};
use crate::config::{self, Config, ConfigError};
use crate::diagnostic::Problem;
use crate::flow::Inferred;
use crate::index::{CrateInput, Index};
use crate::parallel::{Cores, with_large_stack};
use crate::project::Project;
use crate::source::{DiskSource, ReadSource, SourceMap};
use crate::syntax::Directives;

/// What was found for a first configuration.
#[derive(Debug, Default)]
pub struct Prospect {
    /// Every text that was read.
    pub sources: SourceMap,
    /// The candidates of each workspace, by its root.
    pub workspaces: BTreeMap<PathBuf, Candidates>,
    /// The presets that are active, by their names.
    pub presets: Vec<&'static str>,
    /// What could not be read or parsed.
    pub problems: Vec<Problem>,
}

/// Looks for what a first configuration could name, as if there were none yet.
///
/// # Errors
/// If a preset is wrong, which the tests rule out.
pub fn prospect(project: &Project) -> Result<Prospect, ConfigError> {
    let source: Arc<dyn ReadSource> = Arc::new(DiskSource);
    let packages: Vec<usize> = (0..project.packages.len()).collect();
    let Part { mut inputs, sources, problems, .. } = parse::parse(project, &source, &packages);
    parse::link(project, &mut inputs);
    with_large_stack(|| prospect_all(project, inputs, sources, problems))
}

fn prospect_all(
    project: &Project,
    inputs: Vec<CrateInput>,
    sources: SourceMap,
    problems: Vec<Problem>,
) -> Result<Prospect, ConfigError> {
    let config = Config::default();
    let presets = config::active_presets(&config, [Vec::new()], |name| project.graph.contains(name))?;
    let directives = Directives::read(&sources);
    let mut index = Index::build(inputs, paths_outside(&config, &presets));
    entries::add_presets(&presets, &project.graph, &mut index)?;
    let cores = Cores::all();
    let inferred = Inferred::of(&index, &sources, cores);
    let program = inferred.program(&index, &sources, &directives, cores);
    let mut workspaces = BTreeMap::new();
    let reported = || project.packages.iter().enumerate().filter(|(_, package)| package.is_reported);
    for (_, package) in reported() {
        let root = &package.workspace_root;
        let of_workspace = |package: usize| project.packages[package].workspace_root == *root;
        let is_alone = reported().filter(|(number, _)| of_workspace(*number)).count() == 1;
        let scope = scope_of(&project.graph, &index, false, of_workspace);
        workspaces.entry(root.clone()).or_insert_with(|| candidates::find(&program, &scope, is_alone));
    }
    Ok(Prospect { presets: presets.iter().map(|preset| preset.name).collect(), sources, workspaces, problems })
}
