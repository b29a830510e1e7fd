//! Edits that keep the form of the text around them: whole lines in and out, with its own indentation and line ends.

use std::ops::Range;

use crate::project::Manners;
use crate::source::Span;
use crate::syntax::{Lexer, TokenKind};

/// What the lines of a text have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Style {
    /// The line end.
    pub(super) end: &'static str,
    /// One step of indentation.
    pub(super) step: &'static str,
    /// How long a line may be.
    pub(super) width: usize,
}

impl Style {
    /// Reads the whole text.
    pub(super) fn of(text: &str) -> Self {
        let end = if text.contains("\r\n") { "\r\n" } else { "\n" };
        let tabs = text.lines().any(|line| line.starts_with('\t'));
        let widths = text.lines().map(|line| line.len() - line.trim_start_matches(' ').len());
        let step = match widths.filter(|width| *width > 1).min() {
            _ if tabs => "\t",
            Some(2) => "  ",
            Some(3) => "   ",
            Some(8) => "        ",
            _ => "    ",
        };
        Self { end, step, width: Manners::default().width }
    }

    /// The same with the step of a block, whose lines may be indented in another way than others of the text.
    pub(super) fn inside(self, text: &str, block: Range<usize>) -> Self {
        let indent = indentation(text, block.start);
        let lines = text[block].lines().skip(1).filter(|line| !line.trim().is_empty());
        let deeper = lines.filter_map(|line| {
            let rest = line.strip_prefix(indent)?;
            let own = &rest[..rest.len() - rest.trim_start_matches([' ', '\t']).len()];
            (!own.is_empty() && !rest[own.len()..].starts_with('*')).then_some(own)
        });
        let step = match deeper.min_by_key(|own| own.len()) {
            Some("\t") => "\t",
            Some("  ") => "  ",
            Some("   ") => "   ",
            Some("    ") => "    ",
            Some("        ") => "        ",
            _ => self.step,
        };
        Self { step, ..self }
    }
}

/// Puts what is inserted where another edit begins into that edit, so that the order of the two is clear.
pub(super) fn join_insertions(edits: &mut Vec<(Span, String)>) {
    let mut joined: Vec<(Span, String)> = Vec::new();
    for (span, text) in edits.drain(..) {
        match joined.last_mut() {
            Some((before, inserted))
                if before.start == before.end && before.start == span.start && before.file == span.file =>
            {
                *before = span;
                inserted.push_str(&text);
            }
            _ => joined.push((span, text)),
        }
    }
    *edits = joined;
}

/// Where the line of a byte begins; the first one behind the mark of the text's encoding.
pub(super) fn line_start(text: &str, at: usize) -> usize {
    let mark = if text.starts_with('\u{feff}') { '\u{feff}'.len_utf8() } else { 0 };
    text[..at].rfind('\n').map_or(mark.min(at), |newline| newline + 1)
}

/// Where the line of a byte ends, its line end included.
pub(super) fn line_stop(text: &str, at: usize) -> usize {
    text[at..].find('\n').map_or(text.len(), |newline| at + newline + 1)
}

/// The white space at the beginning of the line of a byte.
pub(super) fn indentation(text: &str, at: usize) -> &str {
    let line = &text[line_start(text, at)..];
    &line[..line.len() - line.trim_start_matches([' ', '\t']).len()]
}

/// Whether nothing but white space stands before a byte in its line.
pub(super) fn begins_line(text: &str, at: usize) -> bool {
    text[line_start(text, at)..at].trim().is_empty()
}

/// What to take away so that a statement is gone and the text around it has the form that it would have without it.
pub(super) fn removal(text: &str, stmt: Range<usize>) -> Range<usize> {
    let stop = line_stop(text, stmt.end);
    let rest = text[stmt.end..stop].trim();
    if !begins_line(text, stmt.start) {
        // Something stands before it in its line: the space between the two goes with it.
        let start = text[..stmt.start].trim_end_matches([' ', '\t']).len();
        return start..stmt.end;
    }
    if !rest.is_empty() {
        // A comment or another statement stays where the line begins.
        let gap = text[stmt.end..stop].len() - text[stmt.end..stop].trim_start_matches([' ', '\t']).len();
        return stmt.start..stmt.end + gap;
    }
    let mut range = line_start(text, stmt.start)..stop;
    let above = text[..range.start].strip_suffix('\n').map(|above| &text[line_start(text, above.len())..above.len()]);
    let below = &text[range.end..line_stop(text, range.end)];
    let is_blank = |line: &str| line.trim().is_empty();
    let is_first = above.is_none_or(|line| line.trim_end().ends_with('{'));
    let is_last = below.trim_start().starts_with('}');
    if above.is_some_and(is_blank) && (is_blank(below) || is_last) {
        range.start = line_start(text, range.start - 1);
    } else if is_first && is_blank(below) && !below.is_empty() {
        range.end = line_stop(text, range.end);
    }
    range
}

/// Where the attributes begin that stand before a statement, or the statement if there are none.
pub(super) fn with_attributes(text: &str, stmt: usize) -> usize {
    let mut start = stmt;
    loop {
        let before = text[..start].trim_end();
        let Some(open) =
            before.rfind("#[").filter(|open| before.ends_with(']') && !before[*open..].contains([';', '{', '}']))
        else {
            return start;
        };
        start = open;
    }
}

/// The conditions `#[cfg(…)]` among the attributes right before a byte, in their order.
pub(super) fn conditions_above(text: &str, at: usize) -> Vec<&str> {
    let code = without_comments(&text[..at]);
    let mut start = with_attributes(&code, at);
    let mut found = Vec::new();
    while let Some(stop) = code[start..at].find(']') {
        let mut end = start + stop + 1;
        // A condition may have brackets in it.
        while code[start..end].matches('[').count() > code[start..end].matches(']').count()
            && let Some(more) = code[end..at].find(']')
        {
            end += more + 1;
        }
        let attribute = start + code[start..end].find("#[").unwrap_or(0);
        if code[attribute..end].starts_with("#[cfg(") {
            found.push(&text[attribute..end]);
        }
        start = end;
    }
    found
}

/// The byte before which a line is written so that it stands above the statement at `at`, its attributes and the comments about it.
pub(super) fn above(text: &str, at: usize) -> usize {
    let mut start = line_start(text, at);
    while start > 0 {
        let before = line_start(text, start - 1);
        let line = text[before..start].trim();
        // A comment at the end of a line of code is about that line.
        let is_comment = !line.is_empty() && without_comments(line).trim().is_empty();
        start = match block_comment(text, start) {
            _ if is_comment || line.starts_with("#[") => before,
            Some(open) => line_start(text, open),
            None => break,
        };
    }
    start
}

/// Where a comment in several lines begins that ends with the line before `start`, if that is all there is in these lines.
fn block_comment(text: &str, start: usize) -> Option<usize> {
    let line = text[..start].strip_suffix('\n')?;
    let rest = line.trim_end_matches([' ', '\t', '\r']).strip_suffix("*/")?;
    let open = rest.rfind("/*")?;
    (begins_line(text, open) && !rest[open..].contains("*/")).then_some(open)
}

/// The text with blanks in the place of its comments.
pub(super) fn without_comments(text: &str) -> String {
    without(text, &[TokenKind::LineComment, TokenKind::BlockComment])
}

/// The text with blanks in the place of its comments, of its strings and of its characters.
pub(super) fn code_only(text: &str) -> String {
    without(text, &[TokenKind::LineComment, TokenKind::BlockComment, TokenKind::Literal])
}

fn without(text: &str, kinds: &[TokenKind]) -> String {
    let mut code = String::with_capacity(text.len());
    for token in Lexer::new(text) {
        let part = &text[token.start..token.end];
        if kinds.contains(&token.kind) {
            code.extend(std::iter::repeat_n(' ', part.len()));
        } else {
            code.push_str(part);
        }
    }
    code
}

/// The attributes of a file itself, which stand before everything else in it: `#![no_std]`.
pub(super) fn inner_attributes(text: &str) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let (mut start, mut depth) = (0, 0);
    for token in Lexer::new(text) {
        let part = &text[token.start..token.end];
        match (depth, token.kind, part) {
            (_, TokenKind::Space | TokenKind::LineComment | TokenKind::BlockComment, _) => {}
            (0, _, "\u{feff}") => {}
            (0, TokenKind::Sign, "#") => start = token.start,
            (0, TokenKind::Sign, "!") => {}
            (0, TokenKind::Open, "[") if text[start..].starts_with("#!") => depth = 1,
            (0, ..) => break,
            (_, TokenKind::Open, _) => depth += 1,
            (_, TokenKind::Close, _) => {
                depth -= 1;
                if depth == 0 {
                    found.push(start..token.end);
                }
            }
            _ => {}
        }
    }
    found
}

/// Whether the root of a crate says that it may do without the standard library.
#[must_use]
pub fn is_no_std(text: &str) -> bool {
    inner_attributes(text).into_iter().any(|attribute| has_word(&text[attribute], "no_std"))
}

/// Whether the root of a crate denies one of these lints.
pub(super) fn denies(text: &str, lints: &[&str]) -> bool {
    has_level(text, &["deny", "forbid"], lints)
}

/// Whether the root of a crate gives one of these lints one of these levels.
pub(super) fn has_level(text: &str, levels: &[&str], lints: &[&str]) -> bool {
    let gives = |attribute: &str| {
        levels.iter().any(|level| has_word(attribute, level)) && lints.iter().any(|lint| has_word(attribute, lint))
    };
    inner_attributes(text).into_iter().any(|attribute| gives(&text[attribute]))
}

/// Whether a word stands somewhere in the text.
pub(super) fn has_word(text: &str, word: &str) -> bool {
    words(text, word).next().is_some()
}

/// Where a word stands in the text.
pub(super) fn words<'t>(text: &'t str, word: &'t str) -> impl Iterator<Item = usize> + 't {
    let is_of_word = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(word)
        .map(|(at, _)| at)
        .filter(move |at| !text[..*at].ends_with(is_of_word) && !text[at + word.len()..].starts_with(is_of_word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: &str) {
        let start = text.find("f.u();").expect("it is there");
        let range = removal(text, start..start + 6);
        let mut text = text.to_owned();
        text.replace_range(range, "");
        assert_eq!(text, expected);
    }

    #[test]
    fn a_step_is_the_least_indentation() {
        let step = |text: &str| Style::of(text).step;
        assert_eq!(step("fn f() {\n   if a {\n      b();\n   }\n}\n"), "   ");
        assert_eq!(step("/*\n * a\n */\nfn f() {\n        b();\n}\n"), "        ");
        assert_eq!(step("fn f() {\n  b();\n}\n"), "  ");
        assert_eq!(step("fn f() {\n\tb();\n}\n"), "\t");
        assert_eq!(step("fn f() {}\n"), "    ");
    }

    #[test]
    fn a_block_may_have_a_step_of_its_own() {
        let step = |text: &str, of: &str| {
            let start = text.find(of).expect("it is there");
            let end = start + text[start..].find("\n}").expect("it ends");
            Style::of(text).inside(text, start..end).step
        };
        let text = "fn f() {\n\ta();\n}\nimpl A {\n  fn f() {\n    b();\n  }\n}\nimpl B {\n}\n";
        assert_eq!((step(text, "fn f"), step(text, "impl A"), step(text, "impl B")), ("\t", "  ", "\t"));
        let text = "mod m {\n   impl A {\n       fn f() {}\n   }\n}\n";
        assert_eq!(step(text, "impl A"), "    ");
    }

    #[test]
    fn a_statement_goes_with_its_line() {
        check("{\n    a();\n    f.u();\n    b();\n}\n", "{\n    a();\n    b();\n}\n");
        check("{\r\n\ta();\r\n\tf.u();\r\n}\r\n", "{\r\n\ta();\r\n}\r\n");
        check("{\n    f.u();\n}", "{\n}");
    }

    #[test]
    fn blank_lines_do_not_add_up() {
        check("{\n    a();\n\n    f.u();\n\n    b();\n}\n", "{\n    a();\n\n    b();\n}\n");
        check("{\n    a();\n\n    f.u();\n}\n", "{\n    a();\n}\n");
        check("{\n    f.u();\n\n    b();\n}\n", "{\n    b();\n}\n");
        check("f.u();\n\nb();\n", "b();\n");
        check("{\n    a();\n\n    f.u();\n    b();\n}\n", "{\n    a();\n\n    b();\n}\n");
    }

    #[test]
    fn what_else_stands_in_the_line_stays() {
        check("{ a(); f.u(); b(); }", "{ a(); b(); }");
        check("{ f.u(); }", "{ }");
        check("{\n    f.u(); // predict\n}", "{\n    // predict\n}");
        check("{\n    f.u(); b();\n}", "{\n    b();\n}");
    }

    #[test]
    fn comments_and_attributes_stay_with_their_statement() {
        let text = "    a(); // one\n    // two\n    #[x]\n    loop {";
        assert_eq!(above(text, text.find("loop").unwrap()), text.find("    // two").unwrap());
        let text = "    a(); /* one */\n    /* two\n     * three */\n    /* four */ // five\n    loop {";
        assert_eq!(above(text, text.find("loop").unwrap()), text.find("    /* two").unwrap());
    }

    #[test]
    fn attributes_go_with_their_statement() {
        let start = |text: &str| with_attributes(text, text.find("f.u").expect("it is there"));
        assert_eq!(start("a(); #[x] #[y(z)]\n    f.u();"), 5);
        assert_eq!(start("let a = [1]; f.u();"), 13);
        assert_eq!(start("#[x] fn g() { [1]; } f.u();"), 21);
    }

    #[test]
    fn conditions_are_told_from_other_attributes() {
        let text = "a();\n/// [b]\n#[cfg(c)] // d\n#[e([f])]\n/* g */ #[cfg(all(\n    h\n))]\nimpl I {}";
        let at = text.find("impl").expect("it is there");
        assert_eq!(conditions_above(text, at), ["#[cfg(c)]", "#[cfg(all(\n    h\n))]"]);
        assert!(conditions_above("#[cfg(a)]\nfn b() {}\nimpl I {}", 19).is_empty());
    }

    #[test]
    fn what_a_crate_asks_for_stands_before_its_items() {
        for text in
            ["#![no_std]", "\u{feff}// [\n#![a]\n#![cfg_attr(\n    not(test),\n    no_std\n)]\n", "//! A\n #![no_std]"]
        {
            assert!(is_no_std(text), "{text}");
        }
        for text in ["// #![no_std]", "#[no_std]\nfn f() {}", "mod a {\n#![no_std]\n}", "#![a]\nfn f() { b![no_std] }"]
        {
            assert!(!is_no_std(text), "{text}");
        }
        assert!(denies("#![cfg_attr(a, deny(\n    unused,\n))]", &["warnings", "unused"]));
        assert!(!denies("#![deny(b)]\n#![warn(unused)]", &["warnings", "unused"]));
    }

    #[test]
    fn words_are_whole() {
        assert!(has_word("a kf.b", "kf") && !has_word("kfx akf _kf kf_", "kf"));
    }
}
