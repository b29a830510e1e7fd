//! Files that are the old one or the new one in full, whenever the program is ended.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// Writes the text to a new file beside `target`, through to the device, with the owner and the permissions of `target` if that is
/// there.
///
/// # Errors
/// The system's.
pub fn stage(target: &Path, text: &str) -> io::Result<PathBuf> {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    let path = target.with_file_name(format!(".ceid-lint-{}-{number}.tmp", std::process::id()));
    let mut file = OpenOptions::new().write(true).create_new(true).open(&path)?;
    let written = fill(&mut file, target, text);
    written.inspect_err(|_| remove(&path))?;
    Ok(path)
}

/// Puts the staged file in the place of `target`, at once.
///
/// # Errors
/// The system's; the staged file stays.
pub fn replace(staged: &Path, target: &Path) -> io::Result<()> {
    fs::rename(staged, target)?;
    // The name is safe when its directory is; where directories cannot be opened, the system takes care of that.
    if let Some(directory) = target.parent().and_then(|directory| File::open(directory).ok()) {
        let _ = directory.sync_all();
    }
    Ok(())
}

/// Gives a file a new text, or makes it.
///
/// # Errors
/// The system's, or that the file must not be written. The old file is left as it is then.
pub fn write(path: &Path, text: &str) -> io::Result<()> {
    // What a symbolic link leads to is written, and the link stays.
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    if fs::metadata(&path).is_ok_and(|old| old.permissions().readonly()) {
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, "the file is read-only"));
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
}
