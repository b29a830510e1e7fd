//! Which packages and targets there are, and what `cfg` holds for them. The only module that asks cargo and git. Never touches the
//! network, never builds, and leaves nothing behind in the user's tree.

mod assemble;
mod cargo_config;
mod cfg;
mod changes;
mod error;
mod features;
mod form;
mod load;
mod loose;
mod manifest;
mod manners;
mod metadata;
mod package_spec;
mod profile;
mod select;
mod selection;
mod strays;
mod terminal;
mod toolchain;
mod workspace;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf, is_separator};

pub use changes::{Changes, Removal};
pub use error::LoadError;
pub use load::{load, load_unresolved, of_file, with_files};
pub use manners::{IDLE_NAMES, Manners, PATHS};
pub use selection::{Features, Names, Partition, Selection, TargetFilter};
pub use strays::{Seen, strays};
pub use terminal::{ProgressWhen, Terminal, terminal};

use crate::diagnostic::Problem;

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
    /// Files and directories that findings are restricted to; empty for no restriction. See [`Project::is_wanted`].
    pub only: Vec<PathBuf>,
    /// The names of all packages of the dependency graph; what the manifests name where the graph cannot be resolved.
    pub graph: BTreeSet<String>,
    /// What could not be loaded while the rest could, by absolute paths.
    pub problems: Vec<Problem>,
}

impl Project {
    /// The innermost package that the path lies in.
    #[must_use]
    pub fn owner(&self, path: &Path) -> Option<usize> {
        let around = self.packages.iter().enumerate().filter(|(_, package)| package.is_around(path));
        around.max_by_key(|(_, package)| package.manifest_path.as_os_str().len()).map(|(number, _)| number)
    }

    /// Whether findings in the file at `path` are wanted, as far as the paths on the command line decide it.
    #[must_use]
    pub fn is_wanted(&self, path: &Path) -> bool {
        self.only.is_empty() || self.only.iter().any(|wanted| path.starts_with(wanted))
    }
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
    /// The root of the workspace it belongs to.
    pub workspace_root: PathBuf,
    /// Whether it is a member of the workspace, and not a path dependency beside it.
    pub is_member: bool,
    /// Whether a run that names no package checks it.
    pub is_default: bool,
    /// Whether findings in it are reported; sources of other packages are read for types and summaries only.
    pub is_reported: bool,
    /// The names its code can call other crates by.
    pub dependencies: Vec<Dependency>,
    /// Its targets whose sources are read.
    pub targets: Vec<Target>,
    /// The files of its targets that are not read, because they were not selected, and of its build script.
    pub roots_left_out: Vec<PathBuf>,
    /// Whether it has a library or a binary whose sources are not read, because it was not selected.
    pub is_partly_read: bool,
    /// What `cfg` holds when it is built, `test` apart: see [`Target::cfg_test`].
    pub cfg: CfgValues,
    /// Whether its features and dependencies are not known, since cargo was not asked: see [`load_unresolved`].
    pub is_unresolved: bool,
    /// Its `[package.metadata.ceid-lint]`.
    pub metadata: Option<serde_json::Value>,
}

impl Package {
    /// Whether the path lies in its directory.
    #[must_use]
    pub fn is_around(&self, path: &Path) -> bool {
        let [own, other] = [&self.manifest_path, path].map(|path| path.as_os_str().as_encoded_bytes());
        // It is asked for each package of a workspace, and bytes are compared faster than the parts of paths.
        let directory = own.iter().rposition(|byte| is_separator(char::from(*byte))).unwrap_or(0);
        let is_around = |directory: &Path| directory.is_absolute() && path.starts_with(directory);
        other.starts_with(&own[..directory]) && self.manifest_path.parent().is_some_and(is_around)
    }
}

/// A crate that a package depends on.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Dependency {
    /// The name in `use`: the renamed one if it is renamed, `-` replaced by `_`.
    pub extern_name: String,
    /// The package's own name.
    pub package_name: String,
    /// Index of the package if its sources are read.
    pub package: Option<usize>,
    /// Whether only tests, examples and benchmarks depend on it.
    pub is_dev: bool,
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
    /// Whether `cfg(test)` holds: in integration tests and benchmarks only. The unit tests of a library are not read.
    pub cfg_test: bool,
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

impl TargetKind {
    /// cargo's word for it, as in "no bin target named".
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Lib => "lib",
            Self::Bin => "bin",
            Self::Example => "example",
            Self::Test => "test",
            Self::Bench => "bench",
        }
    }
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
