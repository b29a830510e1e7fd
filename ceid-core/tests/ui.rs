//! What must not compile, and what its author reads then. Every case has a twin in `tests/ui/pass`, which does the
//! same thing right.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The compiler whose words the `.stderr` files hold. Others say the same in other words.
#[cfg(feature = "std")]
const PINNED: &str = "rustc 1.95.";

#[test]
fn rejected_programs_are_rejected_with_their_error_codes() {
    let library = compile_library("metadata");
    for case in rejected() {
        let output = compile(&library, &case);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success(), "{} compiles", case.display());
        let recorded = fs::read_to_string(case.with_extension("stderr")).expect("each case has its text");
        for code in error_codes(&recorded) {
            assert!(stderr.contains(&code), "{} fails without {code}:\n{stderr}", case.display());
        }
    }
}

/// Some texts list what implements a trait, so that they hold for the default features.
#[cfg(feature = "std")]
#[test]
fn rejected_programs_say_what_to_do() {
    if rustc_says("--version").starts_with(PINNED) {
        let cases = trybuild::TestCases::new();
        rejected().into_iter().filter(|case| !is_quoted_more_fully(case)).for_each(|case| cases.compile_fail(case));
    }
}

/// Whether the text names something of the standard library, which the compiler quotes where it has the source of it (the
/// component `rust-src`).
#[cfg(feature = "std")]
fn is_quoted_more_fully(case: &Path) -> bool {
    let recorded = fs::read_to_string(case.with_extension("stderr")).unwrap_or_default();
    let source = Path::new(rustc_says("--print=sysroot").trim()).join("lib/rustlib/src/rust/library");
    ["$RUST/", "std::"].iter().any(|name| recorded.contains(name)) && source.exists()
}

/// All twins in one program, each in a module of its own: a program is linked in seconds, and there are some fifty.
#[test]
fn their_twins_compile_and_run() {
    let library = compile_library("link");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let twins = sources(&root().join("pass"));
    let names = twins.iter().map(|twin| twin.file_stem().and_then(|name| name.to_str()).expect("it has a name"));
    let (mut modules, mut calls) = (String::new(), String::new());
    for (twin, name) in twins.iter().zip(names) {
        let text = fs::read_to_string(twin).expect("a twin can be read");
        modules += &format!("mod {name} {{\n{text}\npub fn run() {{ main() }}\n}}\n");
        calls += &format!("    println!(\"{name}\");\n    {name}::run();\n");
    }
    let source = folder.join("twins.rs");
    fs::write(&source, format!("{modules}fn main() {{\n{calls}}}\n")).expect("the folder can be written to");
    let program = folder.join("twins");
    let output = program_of(&library, &source, "link").arg("-o").arg(&program).output().expect("rustc can be started");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let output = Command::new(&program).output().expect("the program can be started");
    let (said, why) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{} fails:\n{why}", said.lines().last().unwrap_or_default());
    assert_eq!(said.lines().count(), twins.len(), "{said}");
}

#[test]
fn each_rejected_program_has_a_twin() {
    let names = |cases: Vec<PathBuf>| -> BTreeSet<_> {
        cases.iter().map(|case| case.file_name().expect("a case is a file").to_owned()).collect()
    };
    assert_eq!(names(rejected()), names(sources(&root().join("pass"))));
}

/// The human errors are numbered as in the documentation of the crate; the first line of a case says which one it is.
#[test]
fn each_human_error_has_a_case() {
    let shown: BTreeSet<u32> = rejected()
        .iter()
        .map(|case| fs::read_to_string(case).expect("a case can be read"))
        .filter_map(|text| text.strip_prefix("//! E")?.split_once(':')?.0.parse().ok())
        .collect();
    let missing: Vec<_> = (1..=16).filter(|error| !shown.contains(error)).collect();
    assert!(missing.is_empty(), "no case shows {missing:?}");
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/ui")
}

fn areas() -> Vec<PathBuf> {
    entries(&root()).into_iter().filter(|area| !area.ends_with("pass")).collect()
}

fn rejected() -> Vec<PathBuf> {
    areas().iter().flat_map(|area| sources(area)).collect()
}

fn sources(area: &Path) -> Vec<PathBuf> {
    entries(area).into_iter().filter(|file| file.extension().is_some_and(|extension| extension == "rs")).collect()
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<_> = fs::read_dir(folder)
        .expect("the folder of the cases is there")
        .map(|entry| entry.expect("it can be read").path())
        .collect();
    entries.sort();
    entries
}

fn error_codes(text: &str) -> BTreeSet<String> {
    text.split("error[").skip(1).filter_map(|rest| rest.split_once(']')).map(|(code, _)| code.to_owned()).collect()
}

fn rustc() -> Command {
    Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
}

#[cfg(feature = "std")]
fn rustc_says(question: &str) -> String {
    let output = rustc().arg(question).output().expect("rustc can be started");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The library has no dependencies without its features for other crates, so one call of the compiler builds it. What is left out
/// of it is what is not asked of the tests either.
fn compile_library(emit: &str) -> PathBuf {
    let name = if emit == "link" { "libceid_core.rlib" } else { "libceid_core.rmeta" };
    let library = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs");
    let features = [("std", cfg!(feature = "std")), ("alloc", cfg!(feature = "alloc"))];
    let features = features.into_iter().chain([("must-register", cfg!(feature = "must-register"))]);
    // The words of the compiler are those for a library without features.
    let features = features.filter(|(_, is_there)| *is_there && emit == "link");
    let output = rustc()
        .args(["--edition=2024", "--crate-type=lib", "--crate-name=ceid_core"])
        .args(features.flat_map(|(name, _)| ["--cfg".to_owned(), format!("feature=\"{name}\"")]))
        .arg(format!("--emit={emit}"))
        .arg("-o")
        .args([&library, &source])
        .output()
        .expect("rustc can be started");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    library
}

/// Checks a program as `cargo check` does, without generating code.
fn compile(library: &Path, case: &Path) -> Output {
    let mut rustc = program_of(library, case, "metadata");
    rustc.arg("--out-dir").arg(env!("CARGO_TARGET_TMPDIR")).output().expect("rustc can be started")
}

fn program_of(library: &Path, source: &Path, emit: &str) -> Command {
    let mut rustc = rustc();
    rustc
        .args(["--edition=2024", "--crate-type=bin", "--crate-name=case"])
        .arg(format!("--emit={emit}"))
        .arg("--extern")
        .arg(format!("ceid_core={}", library.display()))
        .arg(source);
    rustc
}
