//! What the user asked to be checked, as plain data. Knows no command line.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use crate::source::stable_hash;

/// What to load and what to report.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// The directory the program was started in; absolute.
    pub current_dir: PathBuf,
    /// `--manifest-path`
    pub manifest_path: Option<PathBuf>,
    /// Files and directories that findings are restricted to.
    pub paths: Vec<PathBuf>,
    /// The one of them whose text is known, though it may not lie on the disk.
    pub unsaved: Option<PathBuf>,
    /// `-p`: names, `name@version`, patterns, package ids.
    pub packages: Vec<String>,
    /// `--workspace`
    pub workspace: bool,
    /// `--exclude`: names and patterns.
    pub exclude: Vec<String>,
    /// `--partition`
    pub partition: Option<Partition>,
    /// Which targets of the selected packages.
    pub targets: TargetFilter,
    /// Which features are on.
    pub features: Features,
    /// `--target`
    pub target: Option<String>,
    /// `--profile`, which is `release` with `--release`.
    pub profile: Option<String>,
    /// `--config` and `-Z`, handed on to cargo word for word.
    pub cargo_options: Vec<String>,
}

impl Selection {
    /// Whether `debug_assertions` do not hold.
    pub(super) fn is_release(&self) -> bool {
        self.profile.as_deref().is_some_and(|name| name == "release" || name == "bench")
    }
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
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Features {
    /// `--features`, each entry split at spaces and commas.
    pub named: Vec<String>,
    /// `--all-features`
    pub all: bool,
    /// `--no-default-features`
    pub no_default: bool,
}

/// One of several parts of the selected packages, which together are all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Partition {
    by: PartitionBy,
    /// From 1 to `of`.
    part: u32,
    of: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PartitionBy {
    /// Every n-th package: parts of the same size.
    Slice,
    /// By the name of the package: a package stays in its part when others come and go.
    Hash,
}

impl Partition {
    /// Whether the part holds the package that is selected `at`-th, from 0, and has this name.
    #[must_use]
    pub fn holds(self, at: usize, name: &str) -> bool {
        let number = match self.by {
            PartitionBy::Slice => at as u64,
            PartitionBy::Hash => stable_hash(name.as_bytes()),
        };
        number % u64::from(self.of) == u64::from(self.part - 1)
    }
}

impl FromStr for Partition {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = "write `slice:M/N` or `hash:M/N`";
        let (kind, numbers) = text.split_once(':').ok_or_else(|| form.to_owned())?;
        let by = match kind {
            "slice" => PartitionBy::Slice,
            "hash" => PartitionBy::Hash,
            _ => return Err(format!("there is no partition by `{kind}`; {form}")),
        };
        let (part, of) = numbers.split_once('/').ok_or_else(|| form.to_owned())?;
        let number = |text: &str| text.parse::<u32>().map_err(|_| format!("`{text}` is not a number; {form}"));
        let (part, of) = (number(part)?, number(of)?);
        if part == 0 || part > of {
            return Err(format!("there is no part {part} of {of}; parts are numbered from 1 to {of}"));
        }
        Ok(Self { by, part, of })
    }
}

/// As in the name of a run: `slice-1-of-3`.
impl fmt::Display for Partition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let by = match self.by {
            PartitionBy::Slice => "slice",
            PartitionBy::Hash => "hash",
        };
        write!(f, "{by}-{}-of-{}", self.part, self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_package_is_in_one_part() {
        for kind in ["slice", "hash"] {
            let parts: Vec<Partition> = (1..=3).map(|part| format!("{kind}:{part}/3").parse().unwrap()).collect();
            for at in 0..20 {
                let name = format!("package-{at}");
                assert_eq!(parts.iter().filter(|part| part.holds(at, &name)).count(), 1);
            }
        }
    }

    #[track_caller]
    fn check_error(text: &str, expected: &str) {
        assert_eq!(text.parse::<Partition>().unwrap_err(), expected);
    }

    #[test]
    fn what_is_wrong_is_said() {
        check_error("1/3", "write `slice:M/N` or `hash:M/N`");
        check_error("slice:1", "write `slice:M/N` or `hash:M/N`");
        check_error("even:1/3", "there is no partition by `even`; write `slice:M/N` or `hash:M/N`");
        check_error("slice:0/3", "there is no part 0 of 3; parts are numbered from 1 to 3");
        check_error("hash:4/3", "there is no part 4 of 3; parts are numbered from 1 to 3");
        check_error("hash:x/3", "`x` is not a number; write `slice:M/N` or `hash:M/N`");
    }
}
