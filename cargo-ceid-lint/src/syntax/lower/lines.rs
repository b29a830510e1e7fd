//! From the parser's places of tokens to bytes. The parser counts characters from the nearest place that it was asked about
//! before, and remembers each: that takes longer and more memory than to look up the line.

use std::ops::Range;

use memchr::memchr_iter;
use proc_macro2::{LineColumn, Span};

/// Where the lines of a text begin, and whether a character is a byte in them.
pub(super) struct Lines(Vec<(usize, bool)>);

impl Lines {
    pub(super) fn of(text: &str) -> Self {
        let mut start = 0;
        let ends = memchr_iter(b'\n', text.as_bytes()).map(|end| end + 1).chain([text.len()]);
        let lines = ends.map(|end| {
            let own = (start, text.as_bytes()[start..end].is_ascii());
            start = end;
            own
        });
        Self(lines.collect())
    }

    /// The bytes of a token of the text.
    pub(super) fn bytes(&self, span: Span) -> Range<usize> {
        match (self.byte(span.start()), self.byte(span.end())) {
            (Some(start), Some(end)) => start..end,
            _ => span.byte_range(),
        }
    }

    fn byte(&self, place: LineColumn) -> Option<usize> {
        let (start, is_ascii) = self.0.get(place.line.checked_sub(1)?)?;
        is_ascii.then_some(start + place.column)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_those_of_the_parser() {
        for text in ["a\nb c\r\n  d", "\"é\nx\" y\nz é w\n\u{a0}v", "\"\n\n\" a", "a", "\n\nf(\n)\n"] {
            let lines = Lines::of(text);
            let tokens: proc_macro2::TokenStream = text.parse().unwrap();
            for token in tokens {
                assert_eq!(lines.bytes(token.span()), token.span().byte_range(), "{text:?}");
            }
        }
        assert_eq!(Lines::of("a\nb").bytes(Span::call_site()), 0..0);
    }
}
