//! Changes as a unified diff.

use similar::TextDiff;

use super::Change;
use crate::source::SourceMap;

/// The diff of one file, as `git apply` and `patch -p1` take it, with the path as it is shown to users.
#[must_use]
pub fn diff(change: &Change, names: &SourceMap) -> String {
    let name = names.display_name(&change.path);
    let diff = TextDiff::from_lines(&*change.old, &*change.new);
    diff.unified_diff().header(&format!("a/{name}"), &format!("b/{name}")).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(old: &str, new: &str, expected: &str) {
        let change = Change { path: "/ws/src/a.rs".into(), old: old.into(), new: new.into() };
        assert_eq!(diff(&change, &SourceMap::new("/ws".into())), expected);
    }

    #[test]
    fn line_endings_stay_what_they_are() {
        check(
            "a\r\nb\r\nc",
            "a\r\nc",
            "--- a/src/a.rs\n+++ b/src/a.rs\n@@ -1,3 +1,2 @@\n a\r\n-b\r\n c\n\\ No newline at end of file\n",
        );
    }
}
