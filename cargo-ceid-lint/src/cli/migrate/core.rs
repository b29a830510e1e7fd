//! Where the sources of ceid-core lie, and how a manifest names them.

use std::path::{Path, PathBuf};

use crate::migrate;

fn not_a_package(path: &Path) -> String {
    format!("`{}` is not a directory with a `Cargo.toml`", path.display())
}

/// The directory of ceid-core's sources that was given.
pub(super) fn core_directory(given: &Path) -> Result<PathBuf, String> {
    let core = given.canonicalize().map_err(|_| not_a_package(given))?;
    let manifest = std::fs::read_to_string(core.join("Cargo.toml")).map_err(|_| not_a_package(given))?;
    if migrate::is_ceid_core(&manifest) {
        return Ok(core);
    }
    Err(format!(
        "the package in `{}` is not `ceid-core`: `--ceid-core-path` names the directory of that one",
        given.display()
    ))
}

/// The directory `core` as the manifest at `manifest` names it.
pub(super) fn relative(core: &Path, manifest: &Path) -> Result<String, String> {
    let core = core_directory(core)?;
    let from =
        manifest.parent().and_then(|parent| parent.canonicalize().ok()).ok_or_else(|| not_a_package(manifest))?;
    let common = core.components().zip(from.components()).take_while(|(one, other)| one == other).count();
    let up = from.components().skip(common).map(|_| "..".to_owned());
    let down = core.components().skip(common).map(|part| part.as_os_str().to_string_lossy().into_owned());
    Ok(up.chain(down).collect::<Vec<_>>().join("/"))
}
