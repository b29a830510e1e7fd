//! Places as services that show a repository want them: paths from its root, one line each.

use std::path::{Component, Path, PathBuf};

use super::files::bytes;
use crate::source::{SourceMap, Span, percent_encoded};

/// The repository that a project lies in.
#[derive(Clone, Debug)]
pub(super) struct Repository {
    root: PathBuf,
}

/// A place on one line; lines and columns from 1, columns in characters, the end exclusive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct LineRange {
    pub(super) line: u32,
    pub(super) start: u32,
    pub(super) end: u32,
}

impl Repository {
    /// The nearest directory above `directory` with a `.git`; `directory` itself where there is none.
    pub(super) fn around(directory: &Path) -> Self {
        let directory = directory.canonicalize().unwrap_or_else(|_| directory.to_owned());
        let root = directory.ancestors().find(|above| above.join(".git").exists()).unwrap_or(&directory);
        Self { root: root.to_owned() }
    }

    /// The path from the root with `/`, or the whole path if the file lies elsewhere.
    pub(super) fn path(&self, path: &Path) -> String {
        let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        path.strip_prefix(&self.root).unwrap_or(&path).to_string_lossy().replace('\\', "/")
    }

    /// The path as a URI: relative to the root, or absolute if the file lies elsewhere.
    pub(super) fn uri(&self, path: &Path) -> String {
        let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        match path.strip_prefix(&self.root) {
            Ok(relative) => encoded(relative),
            Err(_) => format!("file:///{}", encoded(&path)),
        }
    }
}

/// A path with each of its names encoded; a colon is, because a relative path may begin with the name.
fn encoded(path: &Path) -> String {
    let names = path.components().filter_map(|component| match component {
        Component::Normal(name) => Some(name.to_string_lossy()),
        Component::Prefix(prefix) => Some(prefix.as_os_str().to_string_lossy()),
        _ => None,
    });
    names.map(|name| percent_encoded(&name, b"-._~!$&'()*+,;=@")).collect::<Vec<_>>().join("/")
}

/// The part of a place that lies on its first line.
///
/// Services show a finding on a change only if all of its lines belong to the change.
pub(super) fn first_line(sources: &SourceMap, span: Span) -> LineRange {
    let file = sources.file(span.file);
    let range = bytes(file, span);
    let offset = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
    let start = file.lines.line_column(&file.text, offset(range.start));
    let end_of_line = file.lines.line_range(&file.text, start.line).end;
    let end = range.end.min(end_of_line).max(range.start);
    LineRange {
        line: start.line,
        start: start.column,
        end: file.lines.line_column(&file.text, offset(end)).column.max(start.column),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_encoded_by_segment() {
        assert_eq!(encoded(Path::new("/a b/ü/100%.rs")), "a%20b/%C3%BC/100%25.rs");
        assert_eq!(encoded(Path::new("a:b/c#d?.rs")), "a%3Ab/c%23d%3F.rs");
    }

    #[test]
    fn a_place_over_several_lines_ends_with_its_first() {
        let mut sources = SourceMap::new("/ws".into());
        let file = sources.add(Path::new("/ws/a.rs"), "é loop {\r\n}\n".into());
        assert_eq!(first_line(&sources, Span::new(file, 3, 12)), LineRange { line: 1, start: 3, end: 9 });
        assert_eq!(first_line(&sources, Span::new(file, 3, 7)), LineRange { line: 1, start: 3, end: 7 });
        assert_eq!(first_line(&sources, Span::new(file, 99, 99)), LineRange { line: 3, start: 1, end: 1 });
    }
}
