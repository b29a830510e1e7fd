//! Whole loads of small workspaces that are written for the purpose. Never uses the network.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use super::*;
use crate::project::{Features, Names, TargetFilter};

/// A directory with files that is removed at the end of the test.
pub(in crate::project) struct Tree {
    root: PathBuf,
}

impl Tree {
    pub(in crate::project) fn new(files: &[(&str, &str)]) -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!("ceid-lint-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let root = std::env::temp_dir().canonicalize().unwrap().join(name);
        for (path, text) in files {
            let path = root.join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        Self { root }
    }

    pub(in crate::project) fn path(&self, path: &str) -> PathBuf {
        self.root.join(path)
    }
}

impl Drop for Tree {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.root);
    }
}

const A: &str = "[package]\nname = \"a\"\nversion = \"0.1.0\"\nedition = \"2024\"\n[features]\nfast = []\n";
const B: &str =
    "[package]\nname = \"b\"\nversion = \"0.2.0\"\nedition = \"2024\"\n[dependencies]\na = { path = \"../a\" }\n";

fn two_packages() -> Tree {
    Tree::new(&[
        ("Cargo.toml", "[workspace]\nmembers = [\"a\", \"b\"]\nresolver = \"3\"\n"),
        ("a/Cargo.toml", A),
        ("a/src/lib.rs", ""),
        ("a/src/main.rs", "fn main() {}"),
        ("a/examples/e.rs", "fn main() {}"),
        ("a/tests/t.rs", ""),
        ("b/Cargo.toml", B),
        ("b/src/lib.rs", ""),
        ("b/src/control/pid.rs", ""),
        ("scratch/alone.rs", "fn main() {}"),
    ])
}

fn in_tree(tree: &Tree) -> Selection {
    Selection { current_dir: tree.root.clone(), ..Selection::default() }
}

fn strings(list: &[&str]) -> Vec<String> {
    list.iter().map(|text| (*text).to_owned()).collect()
}

fn reported(project: &Project) -> Vec<String> {
    let mut found = Vec::new();
    for package in &project.packages {
        for target in package.targets.iter().filter(|target| target.is_reported) {
            found.push(format!("{} {} {}", package.name, target.kind.name(), target.name));
        }
    }
    found
}

#[track_caller]
fn check(selection: &Selection, expected: &[&str]) -> Project {
    let project = load(selection).unwrap();
    assert_eq!(reported(&project), expected);
    project
}

#[track_caller]
fn check_error(selection: &Selection, message: &str, help: &str) {
    let error = load(selection).unwrap_err();
    assert!(error.message.contains(message), "{error}");
    assert!(error.help.clone().unwrap_or_default().contains(help), "{:?}", error.help);
}

#[test]
fn a_virtual_root_takes_every_library_binary_and_example() {
    let tree = two_packages();
    let project = check(&in_tree(&tree), &["a lib a", "a bin a", "a example e", "b lib b"]);
    assert!(!tree.path("Cargo.lock").exists(), "nothing may be left behind");
    assert!(!tree.path("target").exists(), "nothing may be left behind");
    assert_eq!(project.packages[1].dependencies[0].package, Some(0));
    assert_eq!(project.notices, Vec::<String>::new());
}

#[test]
fn a_member_directory_takes_its_package() {
    let tree = two_packages();
    let project = check(&Selection { current_dir: tree.path("b/src"), ..Selection::default() }, &["b lib b"]);
    assert!(!project.packages[0].is_reported, "`a` is read for its types");
    assert_eq!(project.packages[0].targets.len(), 1);
}

#[test]
fn packages_are_named_as_for_cargo() {
    let tree = two_packages();
    let id = format!("path+file://{}#0.2.0", tree.path("b").display());
    for spec in ["b", "b@0.2.0", "b@0.2", id.as_str(), "[b-z]"] {
        check(&Selection { packages: strings(&[spec]), ..in_tree(&tree) }, &["b lib b"]);
    }
}

#[test]
fn an_unknown_package_is_an_error_with_the_nearest_name() {
    let tree = two_packages();
    let selection = Selection { packages: strings(&["bb"]), ..in_tree(&tree) };
    check_error(&selection, "package ID specification `bb` did not match any packages", "`b`");
    let selection = Selection { packages: strings(&["z*"]), ..in_tree(&tree) };
    check_error(&selection, "package pattern(s) `z*` not found in workspace", "");
}

#[test]
fn exclude_needs_workspace() {
    let tree = two_packages();
    let selection = Selection { exclude: strings(&["a"]), ..in_tree(&tree) };
    check_error(&selection, "--exclude can only be used together with --workspace", "");
    check(&Selection { workspace: true, ..selection }, &["b lib b"]);
}

#[test]
fn an_unknown_exclude_is_a_warning() {
    let tree = two_packages();
    let project = load(&Selection { workspace: true, exclude: strings(&["zz"]), ..in_tree(&tree) }).unwrap();
    assert!(project.notices[0].contains("excluded package(s) `zz` not found in workspace"));
}

#[test]
fn target_flags_narrow_and_widen() {
    let tree = two_packages();
    let with = |targets: TargetFilter| Selection { targets, packages: strings(&["a"]), ..in_tree(&tree) };
    let named = |name: &str| Names { all: false, named: strings(&[name]) };
    check(&with(TargetFilter { lib: true, ..TargetFilter::default() }), &["a lib a"]);
    check(&with(TargetFilter { bins: named("a"), ..TargetFilter::default() }), &["a bin a"]);
    let all = check(
        &with(TargetFilter { all: true, ..TargetFilter::default() }),
        &["a lib a", "a bin a", "a example e", "a test t"],
    );
    assert!(all.packages[0].targets.iter().all(|target| target.cfg_test == (target.name == "t")));
    let wrong = with(TargetFilter { examples: named("ee"), ..TargetFilter::default() });
    check_error(&wrong, "no example target named `ee` in `a` package", "`e`");
    let none =
        Selection { packages: strings(&["b"]), ..with(TargetFilter { bins: named("x"), ..TargetFilter::default() }) };
    check_error(&none, "no bin target named `x` in `b` package", "");
}

#[test]
fn features_are_those_of_the_command_line() {
    let tree = two_packages();
    let mut selection = in_tree(&tree);
    selection.features.named = strings(&["fast"]);
    let project = load(&selection).unwrap();
    assert!(project.packages[0].cfg.values["feature"].contains("fast"));
    assert!(project.packages[0].cfg.closed.contains("feature"));
    selection.features.named = strings(&["fats"]);
    check_error(&selection, "`fats`", "`fast`");
}

#[test]
fn a_path_restricts_and_takes_its_own_package() {
    let tree = two_packages();
    let project = check(&Selection { paths: vec!["b/src/control".into()], ..in_tree(&tree) }, &["b lib b"]);
    assert!(project.is_wanted(&tree.path("b/src/control/pid.rs")));
    assert!(!project.is_wanted(&tree.path("b/src/lib.rs")));
    check(
        &Selection { paths: vec!["a/tests/t.rs".into()], ..in_tree(&tree) },
        &["a lib a", "a bin a", "a example e", "a test t"],
    );
}

#[test]
fn a_directory_that_is_named_is_no_wish_for_tests() {
    let tree = two_packages();
    check(&Selection { paths: vec!["a".into()], ..in_tree(&tree) }, &["a lib a", "a bin a", "a example e"]);
    check(&Selection { paths: vec![".".into()], ..in_tree(&tree) }, &["a lib a", "a bin a", "a example e", "b lib b"]);
}

#[test]
fn a_file_outside_any_package_is_checked_on_its_own() {
    let tree = two_packages();
    let project = check(&Selection { paths: vec!["scratch/alone.rs".into()], ..in_tree(&tree) }, &["alone bin alone"]);
    assert_eq!(project.root, tree.path("scratch"));
    assert_eq!(project.packages[0].targets[0].edition, "2024");
}

#[test]
fn a_directory_of_packages_without_a_root_is_checked_package_by_package() {
    let tree = Tree::new(&[
        ("robots/a/Cargo.toml", A),
        ("robots/a/src/lib.rs", ""),
        ("robots/b/Cargo.toml", B),
        ("robots/b/src/lib.rs", ""),
        ("robots/broken/Cargo.toml", "[package\n"),
    ]);
    let project = check(&Selection { paths: vec!["robots".into()], ..in_tree(&tree) }, &["a lib a", "b lib b"]);
    assert_eq!(project.packages[1].dependencies[0].package, Some(0));
    assert_eq!(project.problems.len(), 1, "{:?}", project.problems);
}

#[test]
fn a_wrong_manifest_is_told_with_its_place() {
    let tree = Tree::new(&[("Cargo.toml", "[package]\nname = \"a\"\nversion = 3\n"), ("src/lib.rs", "")]);
    let project = check(&in_tree(&tree), &["a lib a"]);
    assert!(project.problems[0].message.contains("Cargo.toml:3:"), "{:?}", project.problems);
    assert!(project.problems[0].help.as_deref().is_some_and(|help| help.contains("correct the manifest")));
}

#[test]
fn an_empty_workspace_says_so_and_is_no_error() {
    let tree = Tree::new(&[("Cargo.toml", "[workspace]\nmembers = []\n")]);
    let project = check(&in_tree(&tree), &[]);
    assert!(project.notices[0].contains("the workspace has no members"));
    let named = Selection { packages: strings(&["a"]), ..in_tree(&tree) };
    check_error(&named, "package ID specification `a` did not match any packages", "");
}

#[test]
fn a_package_without_targets_is_an_error() {
    let tree = Tree::new(&[("Cargo.toml", A)]);
    check_error(&in_tree(&tree), "no targets specified in the manifest", "");
}

#[test]
fn a_missing_manifest_says_what_can_be_named() {
    let tree = Tree::new(&[("x/readme", "")]);
    check_error(
        &Selection { current_dir: tree.path("x"), ..Selection::default() },
        "could not find `Cargo.toml`",
        "cargo ceid-lint .",
    );
    check_error(
        &Selection { manifest_path: Some("no/Cargo.toml".into()), ..in_tree(&tree) },
        "manifest path `no/Cargo.toml` does not exist",
        "",
    );
    check_error(&Selection { paths: vec!["no.rs".into()], ..in_tree(&tree) }, "path `no.rs` does not exist", "");
}

#[test]
fn dependencies_that_cannot_be_fetched_do_not_matter() {
    let manifest = "[package]\nname = \"a\"\nversion = \"0.1.0\"\n[dependencies]\nno-such-crate = { git = \"https://git.example/x\" }\n";
    let tree = Tree::new(&[("Cargo.toml", manifest), ("src/lib.rs", ""), ("Cargo.lock", "version = 4\n")]);
    let project = check(&in_tree(&tree), &["a lib a"]);
    assert_eq!(project.packages[0].dependencies[0].extern_name, "no_such_crate");
    assert_eq!(project.notices.len(), 1, "{:?}", project.notices);
    assert_eq!(std::fs::read_to_string(tree.path("Cargo.lock")).unwrap(), "version = 4\n");
}

#[test]
fn a_toolchain_that_is_not_installed_does_not_stop_it() {
    let tree = two_packages();
    std::fs::write(tree.path("rust-toolchain.toml"), "[toolchain]\nchannel = \"1.0.1\"\n").unwrap();
    check(&in_tree(&tree), &["a lib a", "a bin a", "a example e", "b lib b"]);
}

#[test]
fn the_configured_build_target_decides_cfg() {
    let tree = two_packages();
    std::fs::create_dir(tree.path(".cargo")).unwrap();
    std::fs::write(tree.path(".cargo/config.toml"), "[build]\ntarget = \"x86_64-pc-windows-msvc\"\n").unwrap();
    let project = load(&in_tree(&tree)).unwrap();
    assert!(project.packages[0].cfg.flags.contains("windows"));
    assert!(!project.packages[0].cfg.flags.contains("unix"));
}

#[test]
fn how_dependencies_are_resolved_is_asked_only_if_it_may_matter() {
    let lock = "version = 4\n\n[[package]]\nname = \"a\"\nversion = \"0.1.0\"\n\n[[package]]\nname = \"b\"\nversion = \"0.2.0\"\ndependencies = [\n \"a\",\n]\n";
    let tree = two_packages();
    assert!(load_unresolved(&in_tree(&tree)).is_none(), "there is no lock file");
    std::fs::write(tree.path("Cargo.lock"), lock).unwrap();
    let unresolved = load_unresolved(&in_tree(&tree)).unwrap();
    let whole = load(&in_tree(&tree)).unwrap();
    assert_eq!(reported(&unresolved), reported(&whole));
    assert_eq!(unresolved.graph, whole.graph);
    for (package, resolved) in unresolved.packages.iter().zip(&whole.packages) {
        assert_eq!(package.dependencies, resolved.dependencies);
        // The features of `a` are not those that cargo turns on.
        assert_eq!(package.is_unresolved, package.name == "a");
        assert!(!resolved.is_unresolved);
    }
    let flags = Features { no_default: true, ..Features::default() };
    assert!(load_unresolved(&Selection { features: flags, ..in_tree(&tree) }).is_none());
    let named = Selection { paths: vec![tree.path("b/src")], ..in_tree(&tree) };
    assert!(load_unresolved(&named).is_none());
    let outside = B.replace("../a", "../../elsewhere");
    std::fs::write(tree.path("b/Cargo.toml"), outside).unwrap();
    assert!(load_unresolved(&in_tree(&tree)).is_none(), "a package outside the workspace is found by cargo");
}
