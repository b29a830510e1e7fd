//! What is written compiles without a warning, and does what the code before did.

use std::path::Path;
use std::process::Command;

use super::{cases, entries, package, read};

/// Runs cargo, which has to succeed.
#[track_caller]
pub(super) fn cargo(directory: &Path, args: &[&str]) {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(args)
        .args(["--offline", "--target-dir"])
        .arg(Path::new(env!("CARGO_TARGET_TMPDIR")).join("migrate_target"))
        .current_dir(directory)
        .env_remove("RUSTFLAGS")
        .output()
        .expect("cargo is installed");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success() && !said.contains("warning:"),
        "{said}\n{}",
        String::from_utf8_lossy(&output.stdout)
    );
}

#[test]
fn both_forms_compile_and_do_the_same() {
    let cases = cases();
    let texts = |folder: &str, file: &str| -> Vec<(String, String)> {
        let all = entries(&cases.join(folder)).into_iter();
        all.map(|(name, path)| (format!("{folder}_{name}_{file}"), read(&path.join(format!("{file}.rs"))))).collect()
    };
    let mut binaries = Vec::new();
    for folder in ["migrated", "changed"] {
        binaries.extend(texts(folder, "before"));
        binaries.extend(texts(folder, "after"));
    }
    binaries.extend(entries(&cases.join("refused")).into_iter().map(|(name, path)| (name, read(&path))));
    let (built, checked): (Vec<_>, Vec<_>) = binaries.into_iter().partition(|(name, _)| name.starts_with("migrated_"));
    let directory = package("migrate_compiled", &checked);
    // Names of the cases are no names of crates, and what a refused case does not use is no matter.
    cargo(&directory, &["check", "--quiet", "--bins", "--config", "build.rustflags=['-Adead_code', '-Aunused']"]);
    let directory = package("migrate_built", &built);
    cargo(&directory, &["build", "--quiet", "--bins"]);
    let programs = Path::new(env!("CARGO_TARGET_TMPDIR")).join("migrate_target/debug");
    let printed = |name: &str| {
        let output = Command::new(programs.join(name)).output().expect("it was built");
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    for (name, _) in entries(&cases.join("migrated")) {
        let before = printed(&format!("migrated_{name}_before"));
        assert!(!before.is_empty(), "{name} prints nothing");
        assert_eq!(printed(&format!("migrated_{name}_after")), before, "{name}");
    }
}
