//! Migrations: what they write, word for word; that it compiles and does the same; and what is refused.

mod asked;
mod cases;
mod compiled;
mod editions;
mod guide;
mod halves;
mod unread;

use std::fs;
use std::path::{Path, PathBuf};

use crate::support::program::{Run, run};
use crate::support::{root, workspace};

/// The directory of the cases.
pub(crate) fn cases() -> PathBuf {
    root().join("fixtures/migrate")
}

/// What lies in a directory of cases, by name.
pub(crate) fn entries(directory: &Path) -> Vec<(String, PathBuf)> {
    let entries = fs::read_dir(directory).unwrap_or_else(|error| panic!("{}: {error}", directory.display()));
    let mut found: Vec<(String, PathBuf)> = entries
        .map(|entry| {
            let path = entry.expect("the cases are readable").path();
            (path.file_stem().expect("it has a name").to_string_lossy().into_owned(), path)
        })
        .collect();
    found.sort();
    found
}

pub(crate) fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// A throw-away package that depends on `ceid-core` already, with these binaries.
pub(crate) fn package(name: &str, binaries: &[(String, String)]) -> PathBuf {
    let directory = workspace::temporary(name);
    let core = root().join("ceid-core");
    let manifest = format!(
        "[workspace]\n\n[package]\nname = \"{name}\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[dependencies]\n\
         ceid-core = {{ path = {core:?} }}\n"
    );
    workspace::write(&directory, "Cargo.toml", manifest.as_bytes());
    for (name, text) in binaries {
        workspace::write(&directory, &format!("src/bin/{name}.rs"), text.as_bytes());
    }
    // What the program itself makes of the lines is tested, and not what rustfmt does.
    workspace::write(&directory, "rustfmt.toml", b"disable_all_formatting = true\n");
    // The versions are those of this workspace, so that nothing has to be looked up.
    fs::copy(root().join("Cargo.lock"), directory.join("Cargo.lock")).expect("the workspace has a lock file");
    directory
}

/// Runs `migrate` in a directory that no version control keeps.
pub(crate) fn migrate(directory: &Path, args: &[&str]) -> Run {
    run(directory, [&["migrate", "--allow-no-vcs"], args].concat())
}

/// The texts of the binaries of a package.
pub(crate) fn binary(directory: &Path, name: &str) -> String {
    read(&directory.join(format!("src/bin/{name}.rs")))
}
