//! What migrated code needs of the manifests of its packages.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::Report;
use crate::migrate::{self, Plan, Rewrite, Wanted};
use crate::project::{Package, Project};
use crate::source::ReadSource;

/// The manifests that plans are about, and the roots of the crates of these packages.
pub(super) fn of_plans(project: &Project, plans: &[Plan], source: &dyn ReadSource) -> BTreeMap<PathBuf, Arc<str>> {
    let rewrites = plans.iter().flat_map(Plan::rewrites).map(|(_, rewrite)| rewrite);
    let packages: BTreeSet<usize> = rewrites.flat_map(Rewrite::packages).collect();
    let packages = packages.iter().filter_map(|package| project.packages.get(*package));
    let paths = packages.flat_map(|package| {
        let roots = package.targets.iter().map(|target| target.src_path.clone()).chain(package.roots_left_out.clone());
        roots.chain([package.manifest_path.clone(), workspace_manifest(package)])
    });
    paths.filter_map(|path| Some((path.clone(), source.read(&path).ok()?))).collect()
}

/// What has to be inserted so that rewritten code can use `ceid-core`, into manifests, and into the roots of crates that do not use it
/// and are asked to use all that their packages depend on: the file, the byte, and the text. `core` tells where its sources lie, as the manifest at a path names them; none where cargo finds them in the registry.
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
    for number in rewrite.packages() {
        let package = project.packages.get(number);
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
        // What one loop writes is to do for the others of its package as well, which come after it.
        let mut others = report.plans.iter().flat_map(Plan::rewrites).map(|(_, other)| other);
        let is_asked = others.any(|other| other.needs_alloc && other.packages().contains(&number));
        let of_all = Wanted { needs_alloc: is_asked, ..wanted.clone() };
        let added = |wanted: &Wanted| migrate::dependency(own, workspace.map(|text| &**text), wanted);
        let added = added(&of_all).or_else(|_| added(&wanted))?;
        if added.is_some() {
            let is_rewritten = |target: usize| rewrite.targets.contains(&(number, target));
            insertions.extend(names_in_roots(report, project, package, is_rewritten));
        }
        insertions.extend(added.map(|(at, text)| (path.clone(), at, text)));
    }
    Ok(insertions)
}

/// What the roots of crates get that do not use what their package depends on now.
fn names_in_roots(
    report: &Report,
    project: &Project,
    package: &Package,
    is_rewritten: impl Fn(usize) -> bool,
) -> Vec<(PathBuf, usize, String)> {
    let is_asked = project.manners(&package.manifest_path).has_to_use_dependencies;
    let targets = package.targets.iter().enumerate().filter(|(number, _)| !is_rewritten(*number));
    let roots = targets.map(|(_, target)| &target.src_path).chain(&package.roots_left_out);
    // A build script has dependencies of its own.
    let build_script = build_script(package, report.manifests.get(&package.manifest_path));
    let roots = roots.filter(|root| Some(*root) != build_script.as_ref());
    let roots = roots.filter_map(|root| Some((root, report.manifests.get(root)?)));
    let named = roots.filter(|(_, text)| migrate::asks_for_names(text, is_asked));
    named.filter_map(|(root, text)| migrate::name_in_root(text).map(|(at, name)| (root.clone(), at, name))).collect()
}

fn build_script(package: &Package, manifest: Option<&Arc<str>>) -> Option<PathBuf> {
    let table: Option<toml::Table> = manifest.and_then(|text| text.parse().ok());
    let named = table.as_ref().and_then(|table| table.get("package")?.get("build")?.as_str());
    Some(package.manifest_path.parent()?.join(named.unwrap_or("build.rs")))
}

fn workspace_manifest(package: &Package) -> PathBuf {
    package.workspace_root.join("Cargo.toml")
}

/// Whether a crate of the package does without the standard library.
fn does_without_std(report: &Report, package: &Package) -> bool {
    let is_root = |path: &Path| package.targets.iter().any(|target| target.src_path == path);
    report.sources.files().any(|(_, file)| is_root(&file.path) && migrate::is_no_std(&file.text))
}
