//! Files by their paths, however these are written.

use std::path::Path;

use crate::source::SourceMap;

pub(super) fn same_file(one: &Path, other: &Path) -> bool {
    one == other || matches!((one.canonicalize(), other.canonicalize()), (Ok(one), Ok(other)) if one == other)
}

/// The text of a file, if it was read.
pub(super) fn text_of<'s>(sources: &'s SourceMap, path: &Path) -> Option<&'s str> {
    sources.files().find(|(_, file)| same_file(&file.path, path)).map(|(_, file)| &*file.text)
}
