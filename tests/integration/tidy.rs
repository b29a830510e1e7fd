//! The rules of the house, held over every source file of the linter.

use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};

use crate::support::{RULES, root};

/// The modules from the lowest floor up: each imports only from lower ones and from itself.
const FLOORS: &[&str] = &[
    "parallel",
    "source",
    "diagnostic",
    "config",
    "project",
    "syntax",
    "relevance",
    "index",
    "types",
    "flow",
    "count",
    "suppress",
    "rules",
    "suggest",
    "migrate",
    "candidates",
    "baseline",
    "pipeline",
    "fix",
    "report",
    "draft",
    "snapshot",
    "lsp",
    "cli",
];

/// Crates that are somebody's business alone, with the modules and files that may name them.
const OWNERS: &[(&str, &[&str])] = &[
    ("syn", &["syntax"]),
    // The JSON form is read back by the crate that everybody else reads cargo's messages with.
    ("cargo_metadata", &["project", "report/json/tests.rs"]),
    ("serde", &["config", "project", "report", "lsp"]),
    ("codespan_reporting", &["report"]),
    ("clap", &["cli"]),
];

/// Paths of `std` that are somebody's business alone.
const STD_OWNERS: &[(&str, &[&str])] = &[("process", &["project", "cli", "source/write.rs"])];

/// How long a file may be without a reason. Most are much shorter.
const MOST_LINES: usize = 500;

/// Longer files, with the reason.
const LONG_FILES: &[(&str, &str)] = &[
    ("flow/lower/iterators/mod.rs", "sources, adaptors and consumers of one chain are read together"),
    ("flow/lower/patterns.rs", "one arm for each kind of pattern"),
    ("index/ty.rs", "types with their names resolved, and the one walk that makes them"),
    ("types/expr.rs", "one arm for each kind of expression"),
];

struct File {
    /// Path below `src`, with `/`.
    name: String,
    /// The first part of it: `flow` for `flow/lower/expr.rs`.
    module: String,
    text: String,
}

fn sources() -> Vec<File> {
    let src = root().join("cargo-ceid-lint/src");
    let mut paths = Vec::new();
    collect(&src, &mut paths);
    paths.sort();
    let read = |path: &PathBuf| {
        let name = path.strip_prefix(&src).expect("it lies in src").display().to_string().replace('\\', "/");
        let module = name.split('/').next().unwrap_or_default().trim_end_matches(".rs").to_owned();
        File { name, module, text: std::fs::read_to_string(path).expect("sources are UTF-8") }
    };
    paths.iter().map(read).collect()
}

fn collect(directory: &Path, paths: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(directory).expect("the sources are readable") {
        let path = entry.expect("the sources are readable").path();
        if path.is_dir() {
            collect(&path, paths);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            paths.push(path);
        }
    }
}

/// The first two segments of each path that a file names: `("crate", "flow")`, `("std", "process")`, `("syn", "")`.
#[derive(Default)]
struct Paths(Vec<(String, String)>);

impl Paths {
    fn of(file: &File) -> Self {
        let tree = syn::parse_file(&file.text).unwrap_or_else(|error| panic!("{}: {error}", file.name));
        let mut paths = Self::default();
        paths.visit_file(&tree);
        paths
    }

    fn add_tree(&mut self, tree: &syn::UseTree, first: Option<String>) {
        match (tree, first) {
            (syn::UseTree::Path(path), None) => self.add_tree(&path.tree, Some(path.ident.to_string())),
            (syn::UseTree::Path(path), Some(first)) => self.0.push((first, path.ident.to_string())),
            (syn::UseTree::Name(name), Some(first)) => self.0.push((first, name.ident.to_string())),
            (syn::UseTree::Rename(name), Some(first)) => self.0.push((first, name.ident.to_string())),
            (syn::UseTree::Name(name), None) => self.0.push((name.ident.to_string(), String::new())),
            (syn::UseTree::Rename(name), None) => self.0.push((name.ident.to_string(), String::new())),
            (syn::UseTree::Group(group), first) => {
                group.items.iter().for_each(|item| self.add_tree(item, first.clone()));
            }
            (_, first) => self.0.push((first.unwrap_or_default(), String::new())),
        }
    }
}

impl<'ast> Visit<'ast> for Paths {
    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        self.add_tree(&item.tree, None);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let mut segments = path.segments.iter().map(|segment| segment.ident.to_string());
        if let (Some(first), Some(second)) = (segments.next(), segments.next()) {
            self.0.push((first, second));
        }
        visit::visit_path(self, path);
    }
}

fn floor(module: &str) -> Option<usize> {
    FLOORS.iter().position(|floor| *floor == module)
}

#[track_caller]
fn assert_none(failures: &[String]) {
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

#[test]
fn modules_import_from_lower_floors_only() {
    let mut failures = Vec::new();
    for file in sources() {
        if file.module == "lib" || file.module == "main" {
            continue;
        }
        let Some(own) = floor(&file.module) else {
            failures.push(format!("{}: `{}` has no floor in this test", file.name, file.module));
            continue;
        };
        for (first, second) in Paths::of(&file).0 {
            if first == "crate" && floor(&second).is_some_and(|other| other > own) {
                failures.push(format!("{}: `{}` imports from `{second}`, which is above it", file.name, file.module));
            }
        }
    }
    assert_none(&failures);
}

#[test]
fn dependencies_stay_with_their_owners() {
    let mut failures = Vec::new();
    for file in sources() {
        for (first, second) in Paths::of(&file).0 {
            let owners = OWNERS
                .iter()
                .find(|(name, _)| *name == first)
                .or_else(|| STD_OWNERS.iter().find(|(name, _)| first == "std" && *name == second));
            let is_own =
                |owners: &[&str]| owners.contains(&file.module.as_str()) || owners.contains(&file.name.as_str());
            if owners.is_some_and(|(_, owners)| !is_own(owners) && file.module != "main") {
                failures.push(format!("{}: `{first}::{second}` is not the business of `{}`", file.name, file.module));
            }
        }
    }
    assert_none(&failures);
}

#[test]
fn files_start_with_what_they_are_for() {
    let silent = sources().into_iter().filter(|file| !file.text.starts_with("//! "));
    assert_none(&silent.map(|file| format!("{}: no `//!` sentence", file.name)).collect::<Vec<_>>());
}

#[test]
fn files_are_short() {
    let sources = sources();
    let mut failures = Vec::new();
    for file in &sources {
        let lines = file.text.lines().count();
        let is_excused = LONG_FILES.iter().any(|(name, _)| *name == file.name);
        match (lines > MOST_LINES, is_excused) {
            (true, false) => {
                failures.push(format!("{}: {lines} lines, at most {MOST_LINES} without a reason", file.name));
            }
            (false, true) => failures.push(format!("{}: {lines} lines need no excuse", file.name)),
            _ => {}
        }
    }
    for (name, _) in LONG_FILES {
        if !sources.iter().any(|file| file.name == *name) {
            failures.push(format!("{name} is excused and does not exist"));
        }
    }
    assert_none(&failures);
}

#[test]
fn snapshots_of_messages_have_their_cases() {
    let mut failures = Vec::new();
    for entry in std::fs::read_dir(root().join("tests/snapshots")).expect("the snapshots are there") {
        let path = entry.expect("readable").path();
        let name = path.file_stem().expect("it has a name").to_string_lossy().into_owned();
        let case = name.split_once("__").map(|(rule, case)| root().join(format!("fixtures/rules/{rule}/{case}.rs")));
        if !case.is_some_and(|case| case.is_file()) {
            failures.push(format!("tests/snapshots/{name}.snap has no case"));
        }
    }
    assert_none(&failures);
}

#[test]
fn case_folders_are_rules() {
    let mut failures = Vec::new();
    for entry in std::fs::read_dir(root().join("fixtures/rules")).expect("the cases are there") {
        let path = entry.expect("readable").path();
        let name = path.file_name().expect("it has a name").to_string_lossy().into_owned();
        if !path.is_dir() || !RULES.contains(&name.as_str()) {
            failures.push(format!("fixtures/rules/{name} is no folder of a rule"));
        }
    }
    assert_none(&failures);
}
