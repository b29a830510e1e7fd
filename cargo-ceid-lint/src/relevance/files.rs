//! The files of a package. Never follows a link to a directory: a package with such a link may read anything.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use crate::project::{Package, Project};
use crate::source::MAX_FILE_BYTES;

/// How many directory entries of one package are looked at: data may lie beside code.
const MAX_ENTRIES: usize = 200_000;

/// What lies in the directory of a package.
#[derive(Debug, Default)]
pub(super) struct Listing {
    pub(super) files: Vec<PathBuf>,
    /// Whether code may lie where nobody looked.
    pub(super) is_open: bool,
}

/// The directories of the packages, with their numbers.
pub(super) fn directories(project: &Project) -> BTreeMap<&Path, usize> {
    let packages = project.packages.iter().enumerate();
    packages.filter_map(|(number, package)| Some((directory(package)?, number))).collect()
}

fn directory(package: &Package) -> Option<&Path> {
    package.manifest_path.parent().filter(|directory| directory.is_absolute())
}

/// The code in the directory of a package, without that of packages below it.
pub(super) fn list(package: &Package, number: usize, others: &BTreeMap<&Path, usize>) -> Listing {
    let mut listing = Listing::default();
    let Some(root) = directory(package) else { return Listing { is_open: true, ..listing } };
    let is_inside = |path: &PathBuf| path.starts_with(root) && is_code(path);
    listing.is_open = !package.targets.iter().all(|target| is_inside(&target.src_path));
    let mut left = MAX_ENTRIES;
    let mut open = vec![root.to_owned()];
    while let Some(directory) = open.pop() {
        let Ok(entries) = std::fs::read_dir(&directory) else {
            listing.is_open = true;
            continue;
        };
        for entry in entries {
            left = left.saturating_sub(1);
            let (Ok(entry), false) = (entry, left == 0) else {
                listing.is_open = true;
                return listing;
            };
            let (Ok(kind), path) = (entry.file_type(), entry.path()) else {
                listing.is_open = true;
                continue;
            };
            let is_code = is_code(&path);
            if kind.is_dir() {
                let is_other = others.get(path.as_path()).is_some_and(|other| *other != number);
                if !is_other && !is_left_out(&path, &entry.file_name().to_string_lossy()) {
                    open.push(path);
                }
            } else if is_code && (kind.is_file() || path.is_file()) {
                listing.files.push(path);
            } else if is_code {
                // Opening a pipe would wait for its other end.
                listing.is_open = true;
            } else if kind.is_symlink() && path.is_dir() {
                listing.is_open = true;
            }
        }
    }
    listing
}

/// Whether a name is that of a module: other files are code only where one includes them.
pub(super) fn is_code(path: &Path) -> bool {
    path.extension().is_some_and(|end| end == "rs")
}

/// Directories in which no module lies: hidden ones, and what cargo and npm write.
pub(super) fn is_left_out(path: &Path, name: &str) -> bool {
    name.starts_with('.') || name == "node_modules" || (name == "target" && path.join("CACHEDIR.TAG").is_file())
}

/// Puts the bytes of a file into `text`, in place of what is there.
pub(super) fn read(path: &Path, text: &mut Vec<u8>) -> io::Result<()> {
    text.clear();
    let file = File::open(path)?;
    let length = file.metadata()?.len();
    if length > MAX_FILE_BYTES {
        return Err(io::Error::other("too large"));
    }
    text.reserve(usize::try_from(length).unwrap_or(0) + 1);
    file.take(MAX_FILE_BYTES).read_to_end(text)?;
    Ok(())
}
