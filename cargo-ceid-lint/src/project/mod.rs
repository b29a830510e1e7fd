//! Which packages and targets there are, and what `cfg` holds for them. The only module that asks cargo.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// Everything cargo knows about the workspace that the analysis needs.
#[derive(Clone, Debug, Default)]
pub struct Project {
    /// The workspace root, or the directory of a file checked on its own.
    pub root: PathBuf,
    /// Where cargo builds.
    pub target_directory: PathBuf,
    /// All packages whose sources are read: members, and path dependencies outside the workspace.
    pub packages: Vec<Package>,
    /// What the user should know about how the project was loaded: "cargo metadata failed (…), dependencies are not resolved".
    pub notices: Vec<String>,
}

/// A package.
#[derive(Clone, Debug)]
pub struct Package {
    /// Its name as in the manifest.
    pub name: String,
    /// cargo's package id, word for word.
    pub id: String,
    /// Its version.
    pub version: String,
    /// Its `Cargo.toml`; empty for a file checked on its own.
    pub manifest_path: PathBuf,
    /// Whether findings in it are reported; sources of other packages are read for types and summaries only.
    pub is_reported: bool,
    /// The names its code can call other crates by.
    pub dependencies: Vec<Dependency>,
    /// Its targets whose sources are read.
    pub targets: Vec<Target>,
    /// What `cfg` holds when it is built.
    pub cfg: CfgValues,
    /// Its `[package.metadata.ceid-lint]`.
    pub metadata: Option<serde_json::Value>,
}

/// A crate that a package depends on.
#[derive(Clone, Debug)]
pub struct Dependency {
    /// The name in `use`: the renamed one if it is renamed, `-` replaced by `_`.
    pub extern_name: String,
    /// The package's own name.
    pub package_name: String,
    /// Index of the package if its sources are read.
    pub package: Option<usize>,
}

/// A crate root.
#[derive(Clone, Debug)]
pub struct Target {
    /// Its name as in the manifest.
    pub name: String,
    /// Its name in `use`.
    pub crate_name: String,
    /// What it is.
    pub kind: TargetKind,
    /// The file of its root module.
    pub src_path: PathBuf,
    /// "2015", "2018", "2021", "2024"
    pub edition: String,
    /// Whether findings in it are reported.
    pub is_reported: bool,
    /// The target as `cargo metadata` prints it, copied word for word into JSON messages.
    pub cargo: serde_json::Value,
}

/// The kinds of targets that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum TargetKind {
    /// A library of any kind, procedural macros included.
    Lib,
    /// A binary.
    Bin,
    /// An example.
    Example,
    /// An integration test.
    Test,
    /// A benchmark.
    Bench,
}

/// What `cfg` holds. A name that is neither here nor known to be absent is uncertain.
#[derive(Clone, Debug, Default)]
pub struct CfgValues {
    /// Flags that hold: `unix`, `debug_assertions`.
    pub flags: BTreeSet<String>,
    /// Keys with all values that hold: `feature` with the active features, `target_os` with "linux".
    pub values: BTreeMap<String, BTreeSet<String>>,
    /// Names of flags and keys whose absence means 'no' (`unix`, `windows`, `test`, `feature`, `target_*`, …); another name is
    /// uncertain when it is not set, because a build script may set it.
    pub closed: BTreeSet<String>,
}
