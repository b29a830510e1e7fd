//! What migrated code needs of the manifests of its packages.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::Report;
use crate::migrate::{self, Plan, Rewrite, Wanted};
use crate::project::{Package, Project};
use crate::source::ReadSource;

/// The manifests that plans are about.
pub(super) fn of_plans(project: &Project, plans: &[Plan], source: &dyn ReadSource) -> BTreeMap<PathBuf, Arc<str>> {
    let rewrites = plans.iter().flat_map(Plan::rewrites).map(|(_, rewrite)| rewrite);
    let packages: BTreeSet<usize> = rewrites.flat_map(|rewrite| rewrite.packages.iter().copied()).collect();
    let packages = packages.iter().filter_map(|package| project.packages.get(*package));
    let paths = packages.flat_map(|package| [package.manifest_path.clone(), workspace_manifest(package)]);
    paths.filter_map(|path| Some((path.clone(), source.read(&path).ok()?))).collect()
}

/// What has to be inserted into manifests so that rewritten code can use `ceid-core`: the manifest, the byte, and the text. `core`
/// tells where its sources lie, as the manifest at a path names them; none where cargo finds them in the registry.
///
/// # Errors
/// Why that cannot be done.
pub fn dependencies(
    report: &Report,
    project: &Project,
    rewrite: &Rewrite,
    core: impl Fn(&Path) -> Result<Option<String>, String>,
) -> Result<Vec<(PathBuf, usize, String)>, String> {
    let mut insertions = Vec::new();
    for package in &rewrite.packages {
        let package = project.packages.get(*package);
        let own = package.and_then(|package| Some((package, report.manifests.get(&package.manifest_path)?)));
        let Some((package, own)) = own else {
            return Err("the file belongs to no package, so that it cannot depend on `ceid-core`".to_owned());
        };
        let path = &package.manifest_path;
        let workspace = report.manifests.get(&workspace_manifest(package));
        let wanted = Wanted {
            path: core(path)?,
            is_no_std: does_without_std(report, package),
            needs_alloc: rewrite.needs_alloc,
        };
        let added = migrate::dependency(own, workspace.map(|text| &**text), &wanted)?;
        insertions.extend(added.map(|(at, text)| (path.clone(), at, text)));
    }
    Ok(insertions)
}

fn workspace_manifest(package: &Package) -> PathBuf {
    package.workspace_root.join("Cargo.toml")
}

/// Whether a crate of the package does without the standard library.
fn does_without_std(report: &Report, package: &Package) -> bool {
    let is_root = |path: &Path| package.targets.iter().any(|target| target.src_path == path);
    report.sources.files().any(|(_, file)| is_root(&file.path) && migrate::is_no_std(&file.text))
}
