//! Fixes: what is written, what is refused, and that nothing is lost.

mod safety;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support::program::{Run, run};
use crate::support::workspace::{temporary_package, write};

/// A filter and a loop that updates it once, under a suppression that hides nothing.
pub(crate) const SUPPRESSED: &str = "\
pub trait SampledFilter { fn update(&mut self); }
pub struct Kalman;
impl SampledFilter for Kalman { fn update(&mut self) {} }
pub fn run(mut kf: Kalman) {
    // ceid: allow(skipped_update, reason = \"it was\")
    loop {
        kf.update(); // every cycle
    }
}
";

/// The same without the suppression.
pub(crate) fn unsuppressed() -> String {
    SUPPRESSED.lines().filter(|line| !line.contains("ceid:")).map(|line| format!("{line}\n")).collect()
}

/// A package under version control with everything committed.
pub(crate) fn repository(name: &str, files: &[(&str, &[u8])]) -> PathBuf {
    let directory = temporary_package(name, files);
    write(&directory, ".gitignore", b"/target\nCargo.lock\n");
    git(&directory, &["init", "--quiet"]);
    commit(&directory);
    directory
}

/// Commits everything.
pub(crate) fn commit(directory: &Path) {
    git(directory, &["add", "--all"]);
    let who = ["-c", "user.name=Ada", "-c", "user.email=ada@example.org", "-c", "core.autocrlf=false"];
    git(directory, &[&who[..], &["commit", "--quiet", "--message", "state"]].concat());
}

#[track_caller]
pub(crate) fn git(directory: &Path, args: &[&str]) -> String {
    let output = Command::new("git").args(args).current_dir(directory).output().expect("git is there");
    assert!(output.status.success(), "git {args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

pub(crate) fn read(directory: &Path, path: &str) -> String {
    fs::read_to_string(directory.join(path)).expect("it is there")
}

/// Runs the fixes in a directory.
pub(crate) fn fix(directory: &Path, args: &[&str]) -> Run {
    run(directory, [&["fix"], args].concat())
}
