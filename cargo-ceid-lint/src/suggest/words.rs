//! Text as words, comments and lines: which names code mentions, and what goes with a line.

use std::ops::Range;

use crate::syntax::{Lexer, Token, TokenKind};

/// Where code mentions a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Mention<'a> {
    /// The name behind a dot that follows it.
    pub(super) member: Option<&'a str>,
    /// Whether that is called: `kf.feed(…)`.
    pub(super) is_called: bool,
}

/// The tokens of a part of a text that are neither space nor comments, with places in the whole text.
pub(super) fn code(text: &str, range: Range<usize>) -> Vec<Token> {
    let tokens = Lexer::new(text.get(range.clone()).unwrap_or_default());
    let is_code =
        |token: &Token| !matches!(token.kind, TokenKind::Space | TokenKind::LineComment | TokenKind::BlockComment);
    let placed = |token: Token| Token { start: token.start + range.start, end: token.end + range.start, ..token };
    tokens.filter(is_code).map(placed).collect()
}

/// Whether a comment lies in a part of a text.
pub(super) fn has_comment(text: &str, range: Range<usize>) -> bool {
    let mut tokens = Lexer::new(text.get(range).unwrap_or_default());
    tokens.any(|token| matches!(token.kind, TokenKind::LineComment | TokenKind::BlockComment))
}

/// The mentions of a variable: the word anywhere but as a field of something else, and in strings, where `{kf}` is one.
pub(super) fn mentions<'a>(text: &'a str, range: Range<usize>, name: &str) -> Vec<Mention<'a>> {
    let tokens = code(text, range);
    let is_sign = |at: usize, sign: &str| tokens.get(at).is_some_and(|token| &text[token.start..token.end] == sign);
    let mut found = Vec::new();
    for (at, token) in tokens.iter().enumerate() {
        let own = &text[token.start..token.end];
        let is_field = at > 0 && is_sign(at - 1, ".") && !(at > 1 && is_sign(at - 2, "."));
        let is_mention = match token.kind {
            TokenKind::Word => own == name && !is_field,
            TokenKind::Literal => Lexer::new(own.trim_matches('"')).any(|word| {
                word.kind == TokenKind::Word && own.trim_matches('"').get(word.start..word.end) == Some(name)
            }),
            _ => false,
        };
        if is_mention {
            let member = tokens.get(at + 2).filter(|next| is_sign(at + 1, ".") && next.kind == TokenKind::Word);
            let member = member.filter(|_| token.kind == TokenKind::Word).map(|next| &text[next.start..next.end]);
            // A colon begins the types of a call: `kf.feed::<f64>(…)`.
            let is_called = member.is_some() && (is_sign(at + 3, "(") || is_sign(at + 3, ":"));
            found.push(Mention { member, is_called });
        }
    }
    found
}

/// Whether a part of a text mentions a word, in whatever role.
pub(super) fn has_word(text: &str, range: Range<usize>, word: &str) -> bool {
    code(text, range).iter().any(|token| token.kind == TokenKind::Word && &text[token.start..token.end] == word)
}

/// The line that a byte lies on, without its line break.
pub(super) fn line_of(text: &str, at: usize) -> Range<usize> {
    let start = text[..at].rfind('\n').map_or(0, |before| before + 1);
    let end = text[at..].find('\n').map_or(text.len(), |length| at + length);
    start..end - usize::from(text[start..end].ends_with('\r'))
}

/// The white space that a line begins with.
pub(super) fn indentation(text: &str, at: usize) -> &str {
    let line = &text[line_of(text, at)];
    &line[..line.len() - line.trim_start().len()]
}

/// The line break that ends the line of a byte; that of the line before, if it is the last one.
pub(super) fn line_break(text: &str, at: usize) -> &'static str {
    let end = line_of(text, at).end;
    let is_windows = match text[end..].is_empty() {
        true => text.contains("\r\n"),
        false => text[end..].starts_with("\r\n"),
    };
    if is_windows { "\r\n" } else { "\n" }
}

/// Lines that a statement has for itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct OwnLines {
    /// From the first byte of the first line to the line break of the last one, which is in it.
    pub(super) lines: Range<usize>,
    /// The comment behind the statement, on its last line.
    pub(super) comment: Option<Range<usize>>,
}

/// The lines of a statement, if no other code stands on them.
pub(super) fn own_lines(text: &str, statement: Range<usize>) -> Option<OwnLines> {
    let first = line_of(text, statement.start);
    let last = line_of(text, statement.end);
    if !text[first.start..statement.start].trim().is_empty() || !code(text, statement.end..last.end).is_empty() {
        return None;
    }
    let behind = &text[statement.end..last.end];
    // A comment that goes on over further lines does not speak of this one.
    if behind.contains("/*") && !behind.trim_end().ends_with("*/") {
        return None;
    }
    let comment = Some(statement.end..last.end).filter(|range| !text[range.clone()].trim().is_empty());
    let end = last.end + text[last.end..].find('\n').map_or(0, |length| length + 1);
    Some(OwnLines { lines: first.start..end, comment })
}

/// What is removed with whole lines, so that no blank line is left double, at the head or at the end of a block.
pub(super) fn with_blank_line(text: &str, lines: Range<usize>) -> Range<usize> {
    let above = lines.start.checked_sub(1).map(|end| line_of(text, end));
    let above_text = above.clone().map_or("{", |line| text[line].trim());
    let below = line_of(text, lines.end.min(text.len()));
    let below_text = text[below.clone()].trim();
    let is_there = lines.end < text.len();
    if is_there && below_text.is_empty() && (above_text.is_empty() || above_text.ends_with('{')) {
        return lines.start..below.end + text[below.end..].find('\n').map_or(0, |length| length + 1);
    }
    match above {
        Some(above) if above_text.is_empty() && below_text.starts_with('}') => above.start..lines.end,
        _ => lines,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variable_is_mentioned_by_its_name_and_in_strings() {
        let text = "kf.feed(z); self.kf.x; a..kf; // kf\n print(\"{kf:?} {other}\"); kf . z = 1; my_kf; kf.get::<u8>()";
        let found = mentions(text, 0..text.len(), "kf");
        let members: Vec<_> = found.iter().map(|mention| (mention.member, mention.is_called)).collect();
        assert_eq!(
            members,
            [(Some("feed"), true), (None, false), (None, false), (Some("z"), false), (Some("get"), true)]
        );
    }

    #[track_caller]
    fn check_removed(text: &str, statement: &str, expected: &str) {
        let start = text.find(statement).unwrap();
        let own = own_lines(text, start..start + statement.len()).unwrap();
        let mut left = text.to_owned();
        left.replace_range(with_blank_line(text, own.lines), "");
        assert_eq!(left, expected);
    }

    #[test]
    fn whole_lines_go_with_their_blank_line() {
        check_removed("{\n\ta();\n\tb(); // why\n\tc();\n}", "b();", "{\n\ta();\n\tc();\n}");
        check_removed("{\r\n  a();\r\n\r\n  b();\r\n\r\n  c();\r\n}", "b();", "{\r\n  a();\r\n\r\n  c();\r\n}");
        check_removed("{\n  a();\n\n  b();\n}", "b();", "{\n  a();\n}");
        check_removed("{\n  b();\n\n  c();\n}", "b();", "{\n  c();\n}");
    }

    #[test]
    fn a_statement_beside_others_has_no_line_of_its_own() {
        assert_eq!(own_lines("a(); b();", 5..9), None);
        assert_eq!(own_lines("b(); /* on\n and on */", 0..4), None);
    }
}
