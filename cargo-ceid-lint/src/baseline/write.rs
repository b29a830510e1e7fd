//! Puts the file in its place at once: whenever the program is ended, the old file is there or the new one.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

/// Writes the text to a file beside `path`, through to the device, and puts that in the place of `path`.
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
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let beside = path.with_file_name(format!(".{name}.{}.tmp", std::process::id()));
    let written = File::create(&beside).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        old.map_or(Ok(()), |old| file.set_permissions(old.permissions()))?;
        file.sync_all()
    });
    written.and_then(|()| fs::rename(&beside, &path)).inspect_err(|_| {
        // What is left behind is only in the way, and the error that is told matters more.
        let _ = fs::remove_file(&beside);
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_old_text_stays_where_the_new_one_cannot_be_written() {
        let directory = std::env::temp_dir().join(format!("ceid_baseline_write_{}", std::process::id()));
        fs::create_dir_all(&directory).unwrap();
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
}
