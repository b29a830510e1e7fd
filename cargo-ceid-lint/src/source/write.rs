//! Files that are the old one or the new one in full, whenever the program is ended.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, SystemTime};

/// What stands around the numbers of the process and of the file in the name of a new file.
const PREFIX: &str = ".ceid-lint-";
const SUFFIX: &str = ".tmp";
/// The same of a file that says what is about to be replaced.
const NOTE: &str = ".note";

/// How old a new file can be before it is certain that no process will put it in its place any more.
const ABANDONED: Duration = Duration::from_secs(600);

/// Removes from a directory the new files of runs that were killed before these took their places. To be called before the
/// calling process writes anything itself.
pub fn remove_abandoned(directory: &Path, now: SystemTime) {
    // What a run has noted, somebody may still bring to its end.
    if abandoned_notes(directory, now).is_empty() {
        abandoned(directory, SUFFIX, now).iter().for_each(|path| remove(path));
    }
}

/// The notes in a directory of runs that were killed before they had taken them away.
#[must_use]
pub fn abandoned_notes(directory: &Path, now: SystemTime) -> Vec<PathBuf> {
    abandoned(directory, NOTE, now)
}

/// The files in a directory that runs have made which are gone.
fn abandoned(directory: &Path, suffix: &str, now: SystemTime) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(directory) else { return Vec::new() };
    let is_abandoned = |entry: &fs::DirEntry| {
        let is_old = || {
            let written = entry.metadata().and_then(|metadata| metadata.modified());
            written.is_ok_and(|written| now.duration_since(written).is_ok_and(|age| age > ABANDONED))
        };
        writer(&entry.file_name().to_string_lossy(), suffix)
            .is_some_and(|process| entry.file_type().is_ok_and(|kind| kind.is_file()) && (is_gone(process) || is_old()))
    };
    entries.flatten().filter(is_abandoned).map(|entry| entry.path()).collect()
}

/// The process that has made a new file of this name.
fn writer(name: &str, suffix: &str) -> Option<u32> {
    let (process, number) = name.strip_prefix(PREFIX)?.strip_suffix(suffix)?.split_once('-')?;
    number.parse::<u32>().ok()?;
    process.parse().ok()
}

/// Whether a file has the name of one that is about to take the place of another: it is nothing that anybody has made.
#[must_use]
pub fn is_staged(path: &Path) -> bool {
    path.file_name().is_some_and(|name| writer(&name.to_string_lossy(), SUFFIX).is_some())
}

/// Whether a process has certainly come to its end; only some systems tell without being asked for more.
fn is_gone(process: u32) -> bool {
    let program = |process: &str| fs::read_to_string(Path::new("/proc").join(process).join("comm")).ok();
    // In a container, a number is soon that of another program.
    process == std::process::id() || program("self").is_some_and(|own| program(&process.to_string()) != Some(own))
}

/// Writes the text to a new file beside `target`, through to the device, with the owner and the permissions of `target` if that is
/// there.
///
/// # Errors
/// The system's.
pub fn stage(target: &Path, text: &str) -> io::Result<PathBuf> {
    let (mut file, path) = create(|name| target.with_file_name(name), SUFFIX)?;
    let written = fill(&mut file, target, text);
    written.inspect_err(|_| remove(&path))?;
    Ok(path)
}

/// Writes a note to a new file in a directory, through to the device: it is there before anything that is done after this.
///
/// # Errors
/// The system's.
pub fn note(directory: &Path, text: &str) -> io::Result<PathBuf> {
    let (mut file, path) = create(|name| directory.join(name), NOTE)?;
    let written = file.write_all(text.as_bytes()).and_then(|()| file.sync_all());
    written.inspect_err(|_| remove(&path))?;
    sync(directory);
    Ok(path)
}

/// Makes a new file with a name that no other one has.
fn create(path: impl Fn(String) -> PathBuf, suffix: &str) -> io::Result<(File, PathBuf)> {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    loop {
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path = path(format!("{PREFIX}{}-{number}{suffix}", std::process::id()));
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(file) => return Ok((file, path)),
            // A process that had the same number was killed.
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
}

/// Puts the staged file in the place of `target`, at once.
///
/// # Errors
/// The system's; the staged file stays.
pub fn replace(staged: &Path, target: &Path) -> io::Result<()> {
    fs::rename(staged, target)?;
    if let Some(directory) = target.parent() {
        sync(directory);
    }
    Ok(())
}

/// Brings the names in a directory to the device, without which the files would be lost; where directories cannot be opened, the
/// system takes care of that.
fn sync(directory: &Path) {
    if let Ok(directory) = File::open(directory) {
        let _ = directory.sync_all();
    }
}

/// Gives a file a new text, or makes it.
///
/// # Errors
/// The system's, or that the file must not be written. The old file is left as it is then.
pub fn write(path: &Path, text: &str) -> io::Result<()> {
    // What a symbolic link leads to is written, and the link stays.
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let old = fs::metadata(&path).ok();
    if old.as_ref().is_some_and(|old| old.permissions().readonly()) {
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, "the file is read-only"));
    }
    // A device or a pipe takes the text, and stays what it is: no file may have the place of `/dev/null`.
    if old.is_some_and(|old| !old.is_file() && !old.is_dir()) {
        return fs::write(&path, text);
    }
    let staged = stage(&path, text)?;
    replace(&staged, &path).inspect_err(|_| remove(&staged))
}

fn fill(file: &mut File, target: &Path, text: &str) -> io::Result<()> {
    file.write_all(text.as_bytes())?;
    match fs::metadata(target) {
        Ok(old) => {
            #[cfg(unix)]
            {
                use std::os::unix::fs::{MetadataExt, fchown};
                let new = file.metadata()?;
                if (new.uid(), new.gid()) != (old.uid(), old.gid()) {
                    fchown(&*file, Some(old.uid()), Some(old.gid()))?;
                }
            }
            file.set_permissions(old.permissions())?;
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    file.sync_all()
}

fn remove(staged: &Path) {
    // What is left behind is only in the way, and the error that is told matters more.
    let _ = fs::remove_file(staged);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directory(name: &str) -> PathBuf {
        let directory = std::env::temp_dir().join(format!("ceid-lint-source-{name}-{}", std::process::id()));
        fs::create_dir_all(&directory).unwrap();
        directory
    }

    #[test]
    fn the_old_text_stays_where_the_new_one_cannot_be_written() {
        let directory = directory("write");
        let path = directory.join("b.toml");
        write(&path, "old").unwrap();
        write(&path, "new").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        let mut permissions = fs::metadata(&path).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).unwrap();
        assert!(write(&path, "newer").unwrap_err().to_string().contains("read-only"));
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert!(write(&directory.join("no/b.toml"), "x").is_err());
        assert_eq!(fs::read_dir(&directory).unwrap().count(), 1);
        fs::remove_dir_all(&directory).unwrap();
    }

    #[test]
    fn what_a_killed_run_left_is_removed() {
        let directory = directory("abandoned");
        let own = format!(".ceid-lint-{}-7.tmp", std::process::id());
        // No process has so high a number.
        for name in [own.as_str(), ".ceid-lint-4294967295-0.tmp", ".ceid-lint-x-0.tmp", ".ceid-lint-1.tmp", "ceid.tmp"]
        {
            fs::write(directory.join(name), "new").unwrap();
        }
        remove_abandoned(&directory, SystemTime::now() + 2 * ABANDONED);
        let mut left: Vec<_> = fs::read_dir(&directory).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        left.sort();
        assert_eq!(left, [".ceid-lint-1.tmp", ".ceid-lint-x-0.tmp", "ceid.tmp"]);
        remove_abandoned(&directory.join("no"), SystemTime::now());
        fs::remove_dir_all(&directory).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn permissions_and_links_stay() {
        use std::os::unix::fs::PermissionsExt;
        let directory = directory("link");
        let (path, link) = (directory.join("b.toml"), directory.join("link.toml"));
        write(&path, "old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        write(&link, "new").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        fs::remove_dir_all(&directory).unwrap();
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_device_stays_a_device() {
        use std::os::unix::fs::FileTypeExt;
        let full = Path::new("/dev/full");
        assert!(write(full, "x").is_err(), "it has no room for anything");
        assert!(fs::metadata(full).unwrap().file_type().is_char_device());
    }
}
