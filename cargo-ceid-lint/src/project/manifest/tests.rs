//! What the manifests say, as cargo would have told it.

use super::*;
use crate::project::load::tests::Tree;

#[track_caller]
fn check(files: &[(&str, &str)], expected: &[&str]) {
    let tree = Tree::new(files);
    let workspace = read_workspace(&tree.path("Cargo.toml"), &mut Vec::new()).unwrap();
    let found: Vec<String> = workspace
        .packages
        .iter()
        .map(|package| {
            let targets: Vec<String> =
                package.targets.iter().map(|target| format!("{} {}", target.kind.name(), target.name)).collect();
            format!("{}@{}: {}", package.name, package.version, targets.join(", "))
        })
        .collect();
    assert_eq!(found, expected);
}

const MINIMAL: &str = "[package]\nname = \"demo\"\nversion = \"0.1.0\"\nedition = \"2024\"\n";

#[test]
fn targets_are_discovered_as_cargo_does() {
    check(
        &[
            ("Cargo.toml", MINIMAL),
            ("src/lib.rs", ""),
            ("src/main.rs", ""),
            ("src/bin/a.rs", ""),
            ("src/bin/b/main.rs", ""),
            ("examples/e.rs", ""),
            ("tests/t.rs", ""),
            ("benches/b.rs", ""),
        ],
        &["demo@0.1.0: lib demo, bin demo, bin a, bin b, example e, test t, bench b"],
    );
}

#[test]
fn named_targets_keep_their_paths() {
    check(
        &[
            ("Cargo.toml", &format!("{MINIMAL}autobins = false\n[[bin]]\nname = \"x\"\npath = \"app/x.rs\"\n")),
            ("app/x.rs", ""),
            ("src/main.rs", ""),
        ],
        &["demo@0.1.0: bin x"],
    );
}

#[test]
fn members_are_named_by_patterns_and_inherit() {
    check(
        &[
            (
                "Cargo.toml",
                "[workspace]\nmembers = [\"crates/*\"]\nexclude = [\"crates/old\"]\npackage.version = \"2.0.0\"\n",
            ),
            ("crates/a/Cargo.toml", "[package]\nname = \"a\"\nversion.workspace = true\n"),
            ("crates/a/src/lib.rs", ""),
            ("crates/old/Cargo.toml", "[package]\nname = \"old\"\n"),
            ("crates/not-a-package/readme", ""),
        ],
        &["a@2.0.0: lib a"],
    );
}

#[test]
fn path_dependencies_are_followed_and_are_members_inside_the_workspace() {
    check(
        &[
            ("Cargo.toml", &format!("{MINIMAL}[workspace]\n[dependencies]\nhelper = {{ path = \"helper\" }}\n")),
            ("src/lib.rs", ""),
            ("helper/Cargo.toml", "[package]\nname = \"helper\"\nversion = \"3.0.0\"\n"),
            ("helper/src/lib.rs", ""),
        ],
        &["demo@0.1.0: lib demo", "helper@3.0.0: lib helper"],
    );
}

#[test]
fn a_wrong_manifest_is_an_error_with_its_place() {
    let tree = Tree::new(&[("Cargo.toml", "[package]\nname = \"demo\nversion = 1\n")]);
    let error = read_workspace(&tree.path("Cargo.toml"), &mut Vec::new()).unwrap_err();
    assert!(error.message.contains("Cargo.toml:2:"), "{error}");
}

#[test]
fn ids_are_spelled_as_cargo_spells_them() {
    assert_eq!(package_id(Path::new("/ws/a"), "a", "0.1.0"), "path+file:///ws/a#0.1.0");
    assert_eq!(package_id(Path::new("/ws/a"), "b", "0.1.0"), "path+file:///ws/a#b@0.1.0");
}
