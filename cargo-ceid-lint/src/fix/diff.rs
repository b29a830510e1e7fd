//! Changes as a unified diff.

use similar::TextDiff;

use super::{Change, Edit};
use crate::source::SourceMap;

/// The diff of one file, as `git apply` and `patch -p1` take it, with the path as it is shown to users.
#[must_use]
pub fn diff(change: &Change, names: &SourceMap) -> String {
    let name = names.display_name(&change.path);
    let diff = TextDiff::from_lines(&*change.old, &*change.new);
    diff.unified_diff().header(&format!("a/{name}"), &format!("b/{name}")).to_string()
}

/// The line of the old text in whose place a line of the new one stands.
pub(super) fn line_before(change: &Change, line: u32) -> u32 {
    let at = line.saturating_sub(1) as usize;
    let diff = TextDiff::from_lines(&*change.old, &*change.new);
    let around = diff.ops().iter().find(|op| op.new_range().contains(&at));
    let before = around.map_or(at, |op| {
        let old = op.old_range();
        (old.start + (at - op.new_range().start)).min(old.end.max(old.start + 1) - 1)
    });
    u32::try_from(before + 1).unwrap_or(line)
}

/// The line of a text which is the line `line` once these edits are made, which are in order.
pub(super) fn line_before_edits<'e>(text: &str, edits: impl Iterator<Item = &'e Edit>, line: u32) -> u32 {
    let lines_in = |text: &str| i64::try_from(text.matches('\n').count()).unwrap_or(0);
    let mut moved = 0;
    for edit in edits {
        let (Some(before), Some(old)) = (text.get(..edit.start), text.get(edit.start..edit.end)) else { continue };
        if lines_in(before) + moved + lines_in(&edit.text) >= i64::from(line) {
            break;
        }
        moved += lines_in(&edit.text) - lines_in(old);
    }
    u32::try_from(i64::from(line) - moved).unwrap_or(line)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_that_look_alike_are_told_apart() {
        let edit = |start, end, text: &str| Edit { path: "/a.rs".into(), start, end, text: text.to_owned() };
        let edits = [edit(0, 0, "x\n"), edit(4, 6, "")];
        // `a`, `b`, `b`, `b` of which the second `b` goes, and a line above all.
        let before = |line| line_before_edits("a\nb\nb\nb\n", edits.iter(), line);
        assert_eq!([2, 3, 4].map(before), [1, 2, 4]);
    }

    #[test]
    fn a_line_is_that_in_whose_place_it_stands() {
        let change = Change { path: "/a.rs".into(), old: "a\nb\nc\nd\n".into(), new: "x\ny\na\nB\nd\n".into() };
        let before: Vec<u32> = (1..=5).map(|line| line_before(&change, line)).collect();
        assert_eq!(before, [1, 1, 1, 2, 4]);
    }

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
