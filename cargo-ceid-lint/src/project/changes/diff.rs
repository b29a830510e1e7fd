//! Reads a diff without context, as git prints it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::{Changes, Lines, Removal};

/// Adds what a diff tells.
pub(super) fn read(diff: &str, top: &Path, changes: &mut Changes) {
    let mut file: Option<PathBuf> = None;
    let mut lines = diff.split('\n');
    while let Some(line) = lines.next() {
        if let Some(name) = line.strip_prefix("+++ ") {
            file = name_of(name).map(|name| top.join(name));
        } else if let Some(hunk) = line.strip_prefix("@@ ").and_then(Hunk::read) {
            // The lines of a hunk are counted, for they may look like anything.
            let mut take = |number: u32, sign: char| -> Vec<&str> {
                let mut taken = Vec::new();
                while taken.len() < number as usize {
                    let Some(line) = lines.next() else { break };
                    taken.extend(line.strip_prefix(sign));
                }
                taken
            };
            let (removed, added) = (take(hunk.removed, '-'), take(hunk.added, '+'));
            if let (Some(file), 1..) = (&file, hunk.added) {
                let range = (hunk.start, hunk.start + (hunk.added - 1));
                match changes.files.entry(file.clone()).or_insert_with(|| Lines::Ranges(Vec::new())) {
                    Lines::Ranges(ranges) => ranges.push(range),
                    Lines::All => {}
                }
            }
            if has_lost_a_call(&removed, &added) {
                let names = removed.iter().flat_map(|line| words(code(line))).map(str::to_owned).collect();
                changes.removals.push(Removal { file: file.clone(), line: hunk.start, names });
            }
        }
    }
}

/// The numbers of a hunk: how many lines went, where the new ones start, and how many they are.
struct Hunk {
    removed: u32,
    start: u32,
    added: u32,
}

impl Hunk {
    /// Reads `-3,2 +4 @@ fn main() {`.
    fn read(text: &str) -> Option<Self> {
        let mut parts = text.split(' ');
        let (_, removed) = Self::numbers(parts.next()?.strip_prefix('-')?)?;
        let (start, added) = Self::numbers(parts.next()?.strip_prefix('+')?)?;
        Some(Self { removed, start, added })
    }

    fn numbers(text: &str) -> Option<(u32, u32)> {
        match text.split_once(',') {
            Some((start, number)) => Some((start.parse().ok()?, number.parse().ok()?)),
            None => Some((text.parse().ok()?, 1)),
        }
    }
}

/// The path behind `+++ `; `None` for a file that is gone.
fn name_of(text: &str) -> Option<String> {
    // A name with a space in it is followed by a tab.
    let text = text.strip_suffix('\r').unwrap_or(text);
    let text = text.strip_suffix('\t').unwrap_or(text);
    let name = match text.strip_prefix('"').and_then(|quoted| quoted.strip_suffix('"')) {
        Some(quoted) => unescaped(quoted),
        None => text.to_owned(),
    };
    name.strip_prefix("b/").map(str::to_owned)
}

/// The text behind the escapes of C, which git uses for names with quotes and control characters.
fn unescaped(text: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = text.bytes().peekable();
    while let Some(byte) = rest.next() {
        if byte != b'\\' {
            bytes.push(byte);
            continue;
        }
        match rest.next() {
            Some(b'n') => bytes.push(b'\n'),
            Some(b't') => bytes.push(b'\t'),
            Some(b'r') => bytes.push(b'\r'),
            Some(b'a') => bytes.push(7),
            Some(b'b') => bytes.push(8),
            Some(b'v') => bytes.push(11),
            Some(b'f') => bytes.push(12),
            Some(first @ b'0'..=b'7') => {
                let mut value = u32::from(first - b'0');
                while let Some(digit) = rest.next_if(|byte| (b'0'..=b'7').contains(byte) && value < 0o40) {
                    value = value * 8 + u32::from(digit - b'0');
                }
                bytes.push(u8::try_from(value).unwrap_or(b'?'));
            }
            other => bytes.extend(other),
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Whether a call was removed that is not among what was added.
fn has_lost_a_call(removed: &[&str], added: &[&str]) -> bool {
    let mut left: BTreeMap<&str, i32> = BTreeMap::new();
    for call in removed.iter().flat_map(|line| calls(code(line))) {
        *left.entry(call).or_default() += 1;
    }
    for call in added.iter().flat_map(|line| calls(code(line))) {
        *left.entry(call).or_default() -= 1;
    }
    left.values().any(|number| *number > 0)
}

/// A line without the comment at its end.
fn code(line: &str) -> &str {
    line.split("//").next().unwrap_or(line)
}

/// What stands before each opening bracket of a call: `self.kf.update`, `step`, `ceid!`.
fn calls(line: &str) -> impl Iterator<Item = &str> {
    line.match_indices(['(', '{', '[']).filter_map(|(at, bracket)| {
        let before = &line[..at];
        let name = before.trim_end_matches('!');
        let is_part = |letter: char| letter.is_alphanumeric() || matches!(letter, '_' | '.' | ':');
        let start = name.trim_end_matches(is_part).len();
        let is_macro = name.len() < before.len();
        (name.len() > start && (bracket == "(" || is_macro)).then(|| &before[start..])
    })
}

fn words(text: &str) -> BTreeSet<&str> {
    text.split(|letter: char| !letter.is_alphanumeric() && letter != '_').filter(|word| !word.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changes(diff: &str) -> Changes {
        let mut changes = Changes::default();
        read(diff, Path::new("/r"), &mut changes);
        changes
    }

    #[test]
    fn lines_and_removals_are_read() {
        let it = changes(
            "diff --git a/src/a.rs b/src/a.rs\n--- a/src/a.rs\n+++ b/src/a.rs\n@@ -3 +3,2 @@ fn f() {\n-    a.update();\n\
             +    b.update();\n++++ b/no.rs\n@@ -9,2 +10,0 @@\n-    // kf.update();\n---- x\n@@ -20,0 +20 @@\n+x\n",
        );
        assert!(it.touch(Path::new("/r/src/a.rs"), 4, 4) && it.touch(Path::new("/r/src/a.rs"), 1, 3));
        assert!(!it.touch(Path::new("/r/src/a.rs"), 5, 19) && it.touch(Path::new("/r/src/a.rs"), 20, 20));
        assert!(!it.touch(Path::new("/r/no.rs"), 1, 99));
        let removal =
            Removal { file: Some("/r/src/a.rs".into()), line: 3, names: ["a", "update"].map(str::to_owned).into() };
        assert_eq!(it.removals, [removal]);
    }

    #[test]
    fn a_file_that_is_gone_still_tells_what_it_called() {
        let it = changes(
            "--- a/x.rs\n+++ /dev/null\n@@ -1,2 +0,0 @@\n-fn f() {\n-g(&mut kf);\n\\ No newline at end of file\n",
        );
        assert_eq!(it.removals.len(), 1);
        assert!(it.removals[0].file.is_none() && it.removals[0].names.contains("kf"));
    }

    #[test]
    fn names_of_all_kinds_are_read() {
        assert_eq!(name_of("b/my arm/a b.rs\t").as_deref(), Some("my arm/a b.rs"));
        assert_eq!(name_of("b/src/ü.rs").as_deref(), Some("src/ü.rs"));
        assert_eq!(name_of("\"b/a\\\"b\\303\\274\\tc.rs\"").as_deref(), Some("a\"bü\tc.rs"));
        assert_eq!(name_of("/dev/null"), None);
    }

    #[track_caller]
    fn check(removed: &str, added: &str, is_lost: bool) {
        assert_eq!(has_lost_a_call(&[removed], &[added]), is_lost, "{removed} -> {added}");
    }

    #[test]
    fn a_call_is_lost_if_it_does_not_come_back() {
        check("self.kf.update();", "", true);
        check("a.update();", "b.update();", true);
        check("a.update(); a.update();", "a.update();", true);
        check("ceid!(cycle => kf);", "", true);
        check("let x = f(1);", "let y = f(2);", false);
        check("speed = 1.0;", "speed = 2.0;", false);
        check("// a.update();", "", false);
        check("if (a) {", "", false);
    }
}
