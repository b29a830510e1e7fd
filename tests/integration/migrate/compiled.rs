//! What is written compiles without a warning, and does what the code before did.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use super::{cases, entries, package, read};
use crate::fixtures_compile::is_crate;

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

/// The programs as modules of one, which is linked once; those that speak of their crate stay by themselves. With the call of each.
fn as_one_program(programs: Vec<(String, String)>) -> Vec<(String, String)> {
    let (mut separate, modules): (Vec<_>, Vec<_>) = programs
        .into_iter()
        .partition(|(_, text)| is_crate(text) || text.contains("process::exit") || text.contains("panic::set_hook"));
    let mut all = String::new();
    let mut calls = String::new();
    for (name, text) in modules {
        write!(all, "mod {name} {{\n{text}\npub fn whole_case() {{ main() }}\n}}\n").expect("a String");
        writeln!(calls, "    println!(\"{BEGINS}{name}\");\n    {name}::whole_case();").expect("a String");
    }
    separate.push((ALL.to_owned(), format!("{all}fn main() {{\n{calls}}}\n")));
    separate
}

/// The program that holds all the others, and what it prints before the name of the one that comes next.
const ALL: &str = "all_of_them";
const BEGINS: &str = "---- ";

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
    let refused = entries(&cases.join("refused")).into_iter();
    binaries.extend(refused.map(|(name, path)| (name.trim_end_matches(".rs").to_owned(), read(&path))));
    let (built, checked): (Vec<_>, Vec<_>) = binaries.into_iter().partition(|(name, _)| name.starts_with("migrated_"));
    let directory = package("migrate_compiled", &as_one_program(checked));
    // Names of the cases are no names of crates, and what a refused case does not use is no matter.
    cargo(&directory, &["check", "--quiet", "--bins", "--config", "build.rustflags=['-Adead_code', '-Aunused']"]);
    let directory = package("migrate_built", &as_one_program(built));
    cargo(&directory, &["build", "--quiet", "--bins"]);
    let programs = Path::new(env!("CARGO_TARGET_TMPDIR")).join("migrate_target/debug");
    let printed = |name: &str| {
        let output = Command::new(programs.join(name)).output().expect("it was built");
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let all = printed(ALL);
    let of_modules: BTreeMap<&str, &str> = all.split(BEGINS).filter_map(|part| part.split_once('\n')).collect();
    let of = |name: &str| of_modules.get(name).map_or_else(|| printed(name), |said| (*said).to_owned());
    for (name, _) in entries(&cases.join("migrated")) {
        let before = of(&format!("migrated_{name}_before"));
        assert!(!before.is_empty(), "{name} prints nothing");
        assert_eq!(of(&format!("migrated_{name}_after")), before, "{name}");
    }
}
