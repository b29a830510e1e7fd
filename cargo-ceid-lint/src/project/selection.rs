//! What the user asked to be checked, as plain data. Knows no command line.

use std::path::PathBuf;

/// What to load and what to report.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// The directory the program was started in; absolute.
    pub current_dir: PathBuf,
    /// `--manifest-path`
    pub manifest_path: Option<PathBuf>,
    /// Files and directories that findings are restricted to.
    pub paths: Vec<PathBuf>,
    /// `-p`: names, `name@version`, patterns, package ids.
    pub packages: Vec<String>,
    /// `--workspace`
    pub workspace: bool,
    /// `--exclude`: names and patterns.
    pub exclude: Vec<String>,
    /// Which targets of the selected packages.
    pub targets: TargetFilter,
    /// Which features are on.
    pub features: Features,
    /// `--target`
    pub target: Option<String>,
    /// Whether `debug_assertions` hold: no with `--release`.
    pub is_release: bool,
    /// `--config` and `-Z`, handed on to cargo word for word.
    pub cargo_options: Vec<String>,
}

/// Which targets of the selected packages; with nothing set: library, binaries and examples.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TargetFilter {
    /// `--lib`
    pub lib: bool,
    /// `--bins`, `--bin`
    pub bins: Names,
    /// `--examples`, `--example`
    pub examples: Names,
    /// `--tests`, `--test`
    pub tests: Names,
    /// `--benches`, `--bench`
    pub benches: Names,
    /// `--all-targets`
    pub all: bool,
}

/// Targets of one kind.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Names {
    /// All of the kind.
    pub all: bool,
    /// These names and patterns.
    pub named: Vec<String>,
}

/// Which features are on.
#[derive(Clone, Debug, Default)]
pub struct Features {
    /// `--features`, each entry split at spaces and commas.
    pub named: Vec<String>,
    /// `--all-features`
    pub all: bool,
    /// `--no-default-features`
    pub no_default: bool,
}
