//! How the file names places in the code: from where it stands, as it is read by others on their own machines.

use std::path::{Component, Path, PathBuf};

use crate::source::{SourceMap, Span};

/// The sources, and the directory that the file stands in.
pub(super) struct Places<'a> {
    pub(super) sources: &'a SourceMap,
    pub(super) root: &'a Path,
}

impl Places<'_> {
    /// The file and the line of a place.
    pub(super) fn of(&self, place: Span) -> String {
        let name = &self.sources.file(place.file).name;
        let name = if Path::new(name).is_absolute() { seen_from(self.root, Path::new(name)) } else { name.clone() };
        format!("{name}:{}", self.sources.line(place))
    }
}

/// The way from a directory to a file, with `..` to leave it. A file of a package in cargo's home begins with that package.
fn seen_from(root: &Path, file: &Path) -> String {
    let parts: Vec<Component<'_>> = file.components().collect();
    let home = parts.windows(2).position(|pair| {
        let [first, second] = [pair[0], pair[1]].map(|part| part.as_os_str().to_string_lossy());
        (first == "registry" && second == "src") || (first == "git" && second == "checkouts")
    });
    let way: PathBuf = match home {
        Some(at) => parts.iter().skip(at + 3).collect(),
        None => {
            let common = root.components().zip(&parts).take_while(|(left, right)| left == *right).count();
            let up = root.components().skip(common).map(|_| Component::ParentDir);
            up.chain(parts.iter().skip(common).copied()).collect()
        }
    };
    way.to_string_lossy().replace('\\', "/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_place_tells_of_the_machine() {
        let seen = |file: &str| seen_from(Path::new("/home/me/robot/firmware"), Path::new(file));
        assert_eq!(seen("/home/me/robot/control/src/pid.rs"), "../control/src/pid.rs");
        assert_eq!(seen("/home/me/robot/firmware/src/main.rs"), "src/main.rs");
        assert_eq!(seen("/home/me/.cargo/registry/src/index-1/pid-4.0.0/src/lib.rs"), "pid-4.0.0/src/lib.rs");
    }
}
