//! From bytes to the positions of the protocol and back, in the units that the client counts in.

use std::ops::Range as Bytes;

use super::protocol::{Position, Range};
use crate::source::Span;

/// The units in which a client counts the characters of a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Encoding {
    /// Bytes.
    Utf8,
    /// What every client knows.
    #[default]
    Utf16,
    /// Unicode scalar values.
    Utf32,
}

impl Encoding {
    /// The protocol's word for it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Utf8 => "utf-8",
            Self::Utf16 => "utf-16",
            Self::Utf32 => "utf-32",
        }
    }

    pub(super) fn of_name(name: &str) -> Option<Self> {
        [Self::Utf8, Self::Utf16, Self::Utf32].into_iter().find(|encoding| encoding.name() == name)
    }

    fn units(self, letter: char) -> usize {
        match self {
            Self::Utf8 => letter.len_utf8(),
            Self::Utf16 => letter.len_utf16(),
            Self::Utf32 => 1,
        }
    }
}

/// A text with the places where its lines begin. As the protocol has it, a line also ends with a lone carriage return.
#[derive(Debug)]
pub(super) struct Lines<'t> {
    text: &'t str,
    starts: Vec<usize>,
}

impl<'t> Lines<'t> {
    pub(super) fn new(text: &'t str) -> Self {
        let bytes = text.as_bytes();
        let ends = bytes.iter().enumerate().filter(|(at, byte)| match byte {
            b'\n' => true,
            b'\r' => bytes.get(at + 1) != Some(&b'\n'),
            _ => false,
        });
        let starts = std::iter::once(0).chain(ends.map(|(at, _)| at + 1)).collect();
        Self { text, starts }
    }

    /// The number of the line that a byte lies in, from 0.
    pub(super) fn line_of(&self, offset: usize) -> usize {
        self.starts.partition_point(|start| *start <= offset).max(1) - 1
    }

    /// The bytes of a line, without its end. Lines behind the last one are empty.
    pub(super) fn bytes(&self, line: usize) -> Bytes<usize> {
        let Some(start) = self.starts.get(line).copied() else { return self.text.len()..self.text.len() };
        let end = self.starts.get(line + 1).copied().unwrap_or(self.text.len());
        let trimmed = self.text.get(start..end).unwrap_or("").trim_end_matches(['\n', '\r']);
        start..start + trimmed.len()
    }

    /// The text of a line, without its end.
    pub(super) fn line(&self, line: usize) -> &'t str {
        self.text.get(self.bytes(line)).unwrap_or("")
    }

    /// Where a byte is, as the client counts.
    pub(super) fn position(&self, offset: usize, encoding: Encoding) -> Position {
        let line = self.line_of(offset);
        let before = self.line(line).char_indices().take_while(|(at, _)| self.starts[line] + at < offset);
        let character: usize = before.map(|(_, letter)| encoding.units(letter)).sum();
        Position { line: to_u32(line), character: to_u32(character) }
    }

    /// The byte that a position means. What lies behind the end of a line means its end.
    pub(super) fn offset(&self, position: Position, encoding: Encoding) -> usize {
        let line = position.line as usize;
        let bytes = self.bytes(line);
        let mut units = 0;
        let wanted = position.character as usize;
        for (at, letter) in self.line(line).char_indices() {
            units += encoding.units(letter);
            if units > wanted {
                return bytes.start + at;
            }
        }
        bytes.end
    }

    /// A range of bytes, as the client counts.
    pub(super) fn range(&self, bytes: Bytes<usize>, encoding: Encoding) -> Range {
        Range { start: self.position(bytes.start, encoding), end: self.position(bytes.end, encoding) }
    }

    /// The place of a span of this text.
    pub(super) fn range_of(&self, span: Span, encoding: Encoding) -> Range {
        self.range(span.start as usize..span.end as usize, encoding)
    }

    /// The bytes that a range means; one that ends before it begins is empty.
    pub(super) fn bytes_of(&self, range: Range, encoding: Encoding) -> Bytes<usize> {
        let start = self.offset(range.start, encoding);
        start..self.offset(range.end, encoding).max(start)
    }
}

fn to_u32(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "a\r\né𝛼x\r\rend";

    #[track_caller]
    fn check(offset: usize, line: u32, characters: [u32; 3]) {
        let lines = Lines::new(TEXT);
        for (encoding, character) in [Encoding::Utf8, Encoding::Utf16, Encoding::Utf32].into_iter().zip(characters) {
            let position = Position { line, character };
            assert_eq!(lines.position(offset, encoding), position, "{encoding:?}");
            assert_eq!(lines.offset(position, encoding), offset, "{encoding:?}");
        }
    }

    #[test]
    fn characters_are_counted_in_the_units_of_the_client() {
        check(0, 0, [0, 0, 0]);
        check(3, 1, [0, 0, 0]);
        check(5, 1, [2, 1, 1]);
        check(9, 1, [6, 3, 2]);
        check(10, 1, [7, 4, 3]);
        check(11, 2, [0, 0, 0]);
        check(15, 3, [3, 3, 3]);
    }

    #[track_caller]
    fn check_offset(line: u32, character: u32, expected: usize) {
        assert_eq!(Lines::new(TEXT).offset(Position { line, character }, Encoding::Utf16), expected);
    }

    #[test]
    fn positions_that_are_not_there_are_moved_to_the_nearest() {
        check_offset(0, 99, 1);
        check_offset(1, 2, 5);
        check_offset(9, 0, TEXT.len());
        check_offset(u32::MAX, u32::MAX, TEXT.len());
    }

    #[test]
    fn an_empty_text_has_one_line() {
        assert_eq!(Lines::new("").position(0, Encoding::Utf16), Position::default());
        assert_eq!(Lines::new("").bytes(0), 0..0);
    }
}
