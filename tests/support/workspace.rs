//! Workspaces to check: the committed ones, and throw-away ones made by a test.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex};
use std::thread::{self, ThreadId};
use std::{fs, io};

/// The directory of a committed workspace.
pub(crate) fn committed(name: &str) -> PathBuf {
    let directory = super::root().join("fixtures/workspaces").join(name);
    assert!(directory.is_dir(), "no workspace `{name}`");
    directory
}

/// A throw-away copy of a committed workspace.
pub(crate) fn copy(workspace: &str, name: &str) -> PathBuf {
    let (from, to) = (committed(workspace), temporary(name));
    copy_all(&from, &to);
    to
}

pub(crate) fn copy_all(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("the target directory is writable");
    for entry in fs::read_dir(from).expect("the workspace is readable") {
        let path = entry.expect("the workspace is readable").path();
        let target = to.join(path.file_name().expect("it has a name"));
        if path.is_dir() {
            copy_all(&path, &target);
        } else {
            fs::copy(&path, &target).expect("the target directory is writable");
        }
    }
}

/// A throw-away directory below the target directory, emptied first.
///
/// # Panics
///
/// Where two tests give one name: they run side by side, and one would empty the directory of the other.
pub(crate) fn temporary(name: &str) -> PathBuf {
    static OWNERS: LazyLock<Mutex<HashMap<String, ThreadId>>> = LazyLock::new(Mutex::default);
    let this = thread::current().id();
    let owner = *OWNERS.lock().expect("nothing panics while it is held").entry(name.to_owned()).or_insert(this);
    assert!(owner == this, "the directory `{name}` is another test's already");
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    match fs::remove_dir_all(&directory) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            panic!("cannot empty {}: {error}", directory.display())
        }
        _ => {}
    }
    fs::create_dir_all(&directory).expect("the target directory is writable");
    directory.canonicalize().expect("it was just made")
}

/// A throw-away package of one library whose files are given as path and content.
pub(crate) fn temporary_package(name: &str, files: &[(&str, &[u8])]) -> PathBuf {
    let directory = temporary(name);
    let manifest = format!("[workspace]\n\n[package]\nname = \"{name}\"\nversion = \"0.0.0\"\nedition = \"2024\"\n");
    write(&directory, "Cargo.toml", manifest.as_bytes());
    for (path, content) in files {
        write(&directory, path, content);
    }
    directory
}

/// Writes a file and the directories above it.
pub(crate) fn write(directory: &Path, path: &str, content: &[u8]) {
    let path = directory.join(path);
    fs::create_dir_all(path.parent().expect("a file lies in a directory")).expect("the directory is writable");
    fs::write(path, content).expect("the directory is writable");
}

/// A module with one certain finding, `repeated_update` on line 7.
pub(crate) const GUILTY: &str = "\
pub trait SampledFilter { fn update(&mut self); }
pub struct Kalman;
impl SampledFilter for Kalman { fn update(&mut self) {} }
pub fn run(mut kf: Kalman) {
    loop {
        kf.update();
        kf.update();
    }
}
";
