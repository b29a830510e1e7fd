//! From bytes to lines and columns. Counts columns in Unicode scalar values, as cargo's JSON does.

use std::sync::OnceLock;

/// A place as people count it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LineColumn {
    /// 1-based line.
    pub line: u32,
    /// 1-based column in Unicode scalar values.
    pub column: u32,
}

/// Where the lines of a text begin. They are found when they are first asked for: nothing is ever shown of most files.
#[derive(Clone, Debug, Default)]
pub struct LineIndex {
    starts: OnceLock<Vec<u32>>,
}

impl LineIndex {
    /// The lines of `text`, which is the same at each call; a line ends with `\n`.
    fn starts(&self, text: &str) -> &[u32] {
        self.starts.get_or_init(|| {
            let breaks = memchr::memchr_iter(b'\n', text.as_bytes());
            std::iter::once(0).chain(breaks.map(|at| to_u32(at + 1))).collect()
        })
    }

    /// Line and column of the byte at `offset`.
    #[must_use]
    pub fn line_column(&self, text: &str, offset: u32) -> LineColumn {
        let line = self.line(text, offset);
        let start = self.starts(text)[line as usize - 1] as usize;
        let end = (offset as usize).min(text.len());
        let column = text.get(start..end).map_or(end - start, |before| before.chars().count());
        LineColumn { line, column: to_u32(column + 1) }
    }

    /// The 1-based line of the byte at `offset`.
    #[must_use]
    pub fn line(&self, text: &str, offset: u32) -> u32 {
        to_u32(self.starts(text).partition_point(|start| *start <= offset).max(1))
    }

    /// The byte range of a 1-based line without its line break.
    #[must_use]
    pub fn line_range(&self, text: &str, line: u32) -> std::ops::Range<usize> {
        let starts = self.starts(text);
        let index = (line.max(1) - 1) as usize;
        let start = starts.get(index).map_or(text.len(), |start| *start as usize);
        let end = starts.get(index + 1).map_or(text.len(), |next| *next as usize);
        let line = text.get(start..end).unwrap_or("");
        start..start + line.trim_end_matches(['\n', '\r']).len()
    }

    /// How many lines there are.
    #[must_use]
    pub fn count(&self, text: &str) -> u32 {
        // Nothing else is asked of most files.
        to_u32(memchr::memchr_iter(b'\n', text.as_bytes()).count() + 1)
    }
}

fn to_u32(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, offset: u32, line: u32, column: u32) {
        assert_eq!(LineIndex::default().line_column(text, offset), LineColumn { line, column });
    }

    #[test]
    fn first_byte_is_line_one_column_one() {
        check("abc", 0, 1, 1);
    }

    #[test]
    fn columns_count_characters_not_bytes() {
        check("é𝛼x", 6, 1, 3);
    }

    #[test]
    fn a_line_break_belongs_to_its_line() {
        check("a\nb\n", 1, 1, 2);
        check("a\nb\n", 2, 2, 1);
    }

    #[test]
    fn carriage_returns_are_not_part_of_the_line() {
        let text = "a\r\nb";
        assert_eq!(LineIndex::default().line_range(text, 1), 0..1);
    }
}
