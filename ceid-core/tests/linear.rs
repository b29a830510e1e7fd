//! With `panic = "abort"`, a path that drops an unregistered filter is a build error. The error comes when code is
//! generated, so that `cargo check`, and with it `trybuild`, cannot show it; and `cargo test` always unwinds. So these
//! cases are built as a package of their own, by whatever toolchain runs the tests, in debug and in release.

#![cfg(feature = "must-register")]

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const MESSAGE: &str = "a sampled-time filter is built but never registered: pass it to `register` of its set";
const PROFILES: [&str; 2] = ["dev", "release"];

#[test]
fn a_program_that_drops_an_unregistered_filter_does_not_build() {
    let package = Package::new("rejected", "abort");
    for case in names("rejected") {
        assert!(package.cargo("check", &case, "dev").status.success(), "{case}: only code generation finds it");
        for profile in PROFILES {
            let output = package.cargo("build", &case, profile);
            let stderr = String::from_utf8_lossy(&output.stderr);
            assert!(!output.status.success(), "{case} builds in {profile}");
            assert!(stderr.contains("error[E0080]") && stderr.contains(MESSAGE), "{case} in {profile}:\n{stderr}");
            assert!(stderr.contains("DutyToRegister<KalmanF>"), "{case} in {profile} names the filter:\n{stderr}");
        }
    }
}

#[test]
fn its_twin_builds_and_runs() {
    let package = Package::new("accepted", "abort");
    for case in names("accepted") {
        for profile in PROFILES {
            let output = package.cargo("run", &case, profile);
            assert!(output.status.success(), "{case} in {profile}:\n{}", String::from_utf8_lossy(&output.stderr));
        }
    }
}

#[test]
fn programs_that_unwind_build() {
    let package = Package::new("accepted", "unwind");
    for case in names("accepted") {
        let output = package.cargo("build", &case, "dev");
        assert!(output.status.success(), "{case}:\n{}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn each_rejected_program_has_a_twin() {
    assert_eq!(names("rejected"), names("accepted"));
}

fn folder(kind: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/linear").join(kind)
}

fn names(kind: &str) -> BTreeSet<String> {
    fs::read_dir(folder(kind))
        .expect("the folder of the cases is there")
        .map(|entry| entry.expect("it can be read").path())
        .map(|file| file.file_stem().expect("a case is a file").to_string_lossy().into_owned())
        .collect()
}

/// A package with one binary a case, in a target directory of its own.
struct Package(PathBuf);

impl Package {
    fn new(kind: &str, panic: &str) -> Self {
        let root = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("linear-{kind}-{panic}"));
        let mut manifest = format!(
            "[workspace]\n\
             [package]\nname = \"linear\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\
             [dependencies]\nceid-core = {{ path = {:?} }}\n\
             [profile.dev]\npanic = {panic:?}\n[profile.release]\npanic = {panic:?}\n",
            env!("CARGO_MANIFEST_DIR")
        );
        for name in names(kind) {
            let path = folder(kind).join(&name).with_extension("rs");
            write!(manifest, "[[bin]]\nname = {name:?}\npath = {path:?}\n").expect("a string takes everything");
        }
        fs::create_dir_all(&root).expect("the target directory can be written");
        fs::write(root.join("Cargo.toml"), manifest).expect("the target directory can be written");
        Self(root)
    }

    fn cargo(&self, command: &str, case: &str, profile: &str) -> Output {
        Command::new(env!("CARGO"))
            .args([command, "--offline", "--quiet", "--profile", profile, "--bin", case])
            .env("CARGO_TARGET_DIR", self.0.join("target"))
            .env_remove("RUSTFLAGS")
            .current_dir(&self.0)
            .output()
            .expect("cargo can be started")
    }
}
