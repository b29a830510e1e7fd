//! What the owner of a file asks of the code in it beside that it compiles: lints in manifests and flags, and the width of lines.

use std::fs;
use std::path::{Path, PathBuf};

use toml::{Table, Value};

use super::{Project, cargo_config};

/// What is asked of the code in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Manners {
    /// Whether a name that nothing uses is an error.
    pub denies_idle_names: bool,
    /// Whether each result is used, or said to be of no use: `unused_results` of the compiler.
    pub has_to_use_results: bool,
    /// Whether each crate names all that its package depends on: `unused_crate_dependencies` of the compiler.
    pub has_to_use_dependencies: bool,
    /// Whether a closure that does nothing but call a method is to be the path of that.
    pub asks_for_paths: bool,
    /// Whether a test, a benchmark or an example beside the sources of the package catches panics.
    pub is_caught_beside: bool,
    /// Whether one of them expects panics.
    pub is_expected_beside: bool,
    /// Whether nobody is to change it: it belongs to files that are not reported.
    pub is_left_alone: bool,
    /// How long a line may be.
    pub width: usize,
}

impl Default for Manners {
    fn default() -> Self {
        Self {
            denies_idle_names: false,
            has_to_use_results: false,
            has_to_use_dependencies: false,
            asks_for_paths: false,
            is_caught_beside: false,
            is_expected_beside: false,
            is_left_alone: false,
            width: 100,
        }
    }
}

/// The lints of the compiler that find names without a use, and the groups they are in.
pub const IDLE_NAMES: [&str; 4] = ["warnings", "unused", "unused_variables", "dead_code"];

/// The lint of clippy that finds closures in the place of paths, and the group it is in.
pub const PATHS: [&str; 2] = ["pedantic", "redundant_closure_for_method_calls"];

impl Project {
    /// What is asked of the code in the file at `path`.
    #[must_use]
    pub fn manners(&self, path: &Path) -> Manners {
        let width = path.ancestors().skip(1).find_map(width);
        let width = width.unwrap_or(Manners::default().width);
        let Some(package) = self.owner(path).map(|number| &self.packages[number]) else {
            return Manners { width, ..Manners::default() };
        };
        let text = |path: &Path| fs::read_to_string(path).unwrap_or_default();
        let root = text(&package.workspace_root.join("Cargo.toml"));
        let flags = cargo_config::read(&self.root, &[], None).rustflags;
        let beside = beside(package.manifest_path.parent().unwrap_or(&package.workspace_root));
        let names = |word: &str| beside.iter().any(|path| text(path).contains(word));
        Manners {
            is_caught_beside: names("catch_unwind"),
            is_expected_beside: names("should_panic"),
            width,
            ..of_lints(&text(&package.manifest_path), &root, &flags)
        }
    }
}

/// The files of a package's tests, benchmarks and examples.
fn beside(root: &Path) -> Vec<PathBuf> {
    let below = |name: &str| walkdir::WalkDir::new(root.join(name)).max_depth(4).into_iter().filter_map(Result::ok);
    let files = ["tests", "benches", "examples"].into_iter().flat_map(below).map(walkdir::DirEntry::into_path);
    files.filter(|path| path.extension().is_some_and(|ending| ending == "rs")).collect()
}

/// The width of lines that a directory's configuration of rustfmt asks for; the default where it does not.
fn width(directory: &Path) -> Option<usize> {
    let read = |name: &str| fs::read_to_string(directory.join(name)).ok();
    let table: Table = read("rustfmt.toml").or_else(|| read(".rustfmt.toml"))?.parse().ok()?;
    let width = table.get("max_width").and_then(Value::as_integer).and_then(|width| usize::try_from(width).ok());
    Some(width.unwrap_or(Manners::default().width))
}

/// What the lints ask for, by the texts of the manifests of a package and of its workspace, and by the flags for the compiler.
fn of_lints(text: &str, workspace: &str, rustflags: &[String]) -> Manners {
    let [own, root]: [Table; 2] = [text, workspace].map(|text| text.parse().unwrap_or_default());
    let own = own.get("lints");
    let is_shared = own.and_then(|lints| lints.get("workspace")).and_then(Value::as_bool) == Some(true);
    let lints = if is_shared { root.get("workspace").and_then(|root| root.get("lints")) } else { own };
    let level_of = |tool: &str, lint: &str| {
        let rust = lints?.get(tool)?;
        let level = rust.get(lint).or_else(|| rust.get(lint.replace('_', "-")))?;
        level.as_str().or_else(|| level.get("level")?.as_str())
    };
    let level = |lint: &str| level_of("rust", lint);
    let asks_for_path = |lint: &&str| level_of("clippy", lint).is_some_and(|level| level != "allow");
    // The compiler reads `unused-results` as `unused_results`.
    let flags = format!("{} ", rustflags.join(" ").replace("--", "-").replace('-', "_"));
    let is_flag = |lint: &str, levels: &[&str]| {
        let forms = levels.iter().flat_map(|level| ["", " ", "="].map(|between| format!("_{level}{between}{lint} ")));
        forms.into_iter().any(|form| flags.contains(&form))
    };
    let is_denied =
        |lint: &&str| matches!(level(lint), Some("deny" | "forbid")) || is_flag(lint, &["D", "F", "deny", "forbid"]);
    let is_told = |lint: &str| {
        level(lint).is_some_and(|level| level != "allow") || is_flag(lint, &["W", "D", "F", "warn", "deny", "forbid"])
    };
    Manners {
        denies_idle_names: IDLE_NAMES.iter().any(is_denied),
        has_to_use_results: is_told("unused_results"),
        has_to_use_dependencies: is_told("unused_crate_dependencies"),
        asks_for_paths: PATHS.iter().any(asks_for_path),
        ..Manners::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, workspace: &str, flags: &str, (names, results): (bool, bool)) {
        let flags: Vec<String> = flags.split_whitespace().map(str::to_owned).collect();
        let found = of_lints(text, workspace, &flags);
        assert_eq!((found.denies_idle_names, found.has_to_use_results), (names, results));
    }

    #[test]
    fn dependencies_have_to_be_used_where_a_lint_says_so() {
        let found = |text: &str| of_lints(text, "", &[]).has_to_use_dependencies;
        assert!(found("[lints.rust]\nunused_crate_dependencies = \"warn\"\n"));
        assert!(!found("[lints.rust]\nunused_crate_dependencies = \"allow\"\nunused = \"deny\"\n"));
    }

    #[test]
    fn lints_are_those_of_the_package_or_of_its_workspace() {
        check("[lints.rust]\nunused = \"deny\"\n", "", "", (true, false));
        check("lints.rust.warnings = { level = \"forbid\", priority = -1 }\n", "", "", (true, false));
        check("[lints.rust]\nunused = \"warn\"\nunused_results = \"warn\"\n", "", "", (false, true));
        let root = "[workspace.lints.rust]\nunused_variables = \"deny\"\nunused_results = \"deny\"\n";
        check("[lints]\nworkspace = true\n", root, "", (true, true));
        check("[package]\nname = \"a\"\n", root, "", (false, false));
        check("[lints.rust]\nunused-variables = \"deny\"\nunused-results = \"warn\"\n", "", "", (true, true));
    }

    #[test]
    fn flags_of_the_compiler_ask_as_well() {
        check("", "", "-Dwarnings", (true, false));
        check("", "", "-C opt-level=3 -D warnings", (true, false));
        check("", "", "--deny=dead_code -Wunused_results", (true, true));
        check("", "", "-Dunused_imports -Wwarnings", (false, false));
        check("", "", "--warn=unused-results -D dead-code", (true, true));
    }
}
