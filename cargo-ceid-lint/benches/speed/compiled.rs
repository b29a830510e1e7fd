//! A workspace that compiles, for the tools that need one: three crates of mathematics out of cargo's registry as members.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::corpus::{self, Corpus};
use super::runs::Row;

const MEMBERS: [&str; 3] = ["nalgebra", "ndarray", "simba"];

/// The workspace, its dependencies resolved; or why there is none.
pub(crate) fn build(root: &Path) -> Result<Corpus, String> {
    let members: Vec<(String, PathBuf)> =
        corpus::crates().into_iter().filter(|(name, _)| MEMBERS.contains(&name.as_str())).collect();
    if members.len() < MEMBERS.len() {
        return Err(format!("cargo's registry lacks one of {MEMBERS:?}; `cargo add` each to a project brings it"));
    }
    let corpus = corpus::write_workspace(root, &members, |_, directory| {
        let text = fs::read_to_string(directory.join("Cargo.toml")).unwrap_or_default();
        let mut manifest: toml::Table = text.parse().expect("cargo wrote it");
        for key in ["dev-dependencies", "bench", "test", "example", "lints"] {
            manifest.remove(key);
        }
        manifest.to_string()
    });
    let patches = MEMBERS.map(|name| format!("{name} = {{ path = \"{name}\" }}\n")).concat();
    let manifest = root.join("Cargo.toml");
    let text = fs::read_to_string(&manifest).unwrap_or_default();
    fs::write(&manifest, format!("{text}\n[patch.crates-io]\n{patches}")).map_err(|error| error.to_string())?;
    let mut check = Command::new("cargo");
    check.args(["check", "--quiet", "--workspace", "--manifest-path"]).arg(&manifest);
    let check = check.arg("--target-dir").arg(target_directory(root)).output();
    match check {
        Ok(output) if output.status.success() => Ok(corpus),
        Ok(output) => Err(String::from_utf8_lossy(&output.stderr).into_owned()),
        Err(error) => Err(error.to_string()),
    }
}

/// Beside the workspace, so that no tool searches it.
fn target_directory(root: &Path) -> PathBuf {
    root.with_extension("target")
}

/// What the compiler costs after every member has changed, its dependencies built.
pub(crate) fn rows(corpus: &Corpus) -> Vec<Row> {
    let (root, target) = (corpus.root.display(), target_directory(&corpus.root));
    let row = |name: &'static str| {
        let command = name.strip_prefix("cargo ").unwrap_or(name);
        let flags = format!("--workspace --manifest-path {root}/Cargo.toml --target-dir {}", target.display());
        Row::new(name, format!("touch {root}/*/src/lib.rs; cargo {command} {flags}"))
    };
    let mut rows = vec![row("cargo check")];
    if super::peers::answers("cargo clippy --version") {
        rows.push(row("clippy"));
    } else {
        println!("clippy is not there; `rustup component add clippy` installs it");
    }
    rows
}
