//! The crates of a package that do not use `ceid-core` once another one of them does: where lints ask for a use of all dependencies,
//! the root of such a crate names it, as the compiler advises.

use std::ops::Range;

use super::text::{
    above, begins_line, has_word, inner_attributes, line_start, line_stop, removal, without_comments, words,
};
use crate::syntax::{Lexer, TokenKind};

const LINT: &str = "unused_crate_dependencies";
const NAME: &str = "use ceid_core as _;";

/// Whether the root of a crate asks for a use of each dependency, or its package does (`is_asked`).
#[must_use]
pub fn asks_for_names(text: &str, is_asked: bool) -> bool {
    match inner_attributes(text).into_iter().rev().find(|range| has_word(&text[range.clone()], LINT)) {
        Some(own) => !["allow", "expect"].iter().any(|level| has_word(&text[own.clone()], level)),
        None => is_asked,
    }
}

/// What the root of a crate gets so that it names `ceid-core`, and at which byte; nothing if it does already.
#[must_use]
pub fn name_in_root(text: &str) -> Option<(usize, String)> {
    let code = without_comments(text);
    if has_word(&code, "ceid_core") {
        return None;
    }
    let end = if text.contains("\r\n") { "\r\n" } else { "\n" };
    if let Some(import) = first_import(text) {
        let above = text[..import].trim_end_matches(' ').strip_suffix('\n').map(|above| above.trim_end_matches('\r'));
        let above = above.map_or("", |above| text[line_start(text, above.len())..above.len()].trim());
        let is_about_it = above.starts_with("//") || above.ends_with("*/") || above.ends_with(']');
        // In the order that rustfmt gives them.
        let is_later = code[import + "use".len()..].trim_start() > "ceid_core";
        let stop = import + code[import..].find(';').map_or(0, |stop| stop);
        return Some(match is_later && !is_about_it {
            true => (import, format!("{NAME}{end}")),
            false => (line_stop(text, stop), format!("{NAME}{end}")),
        });
    }
    let head = inner_attributes(text).last().map_or(0, |last| last.end);
    let head = doc_comments(text).max(head);
    let head = if head == 0 { 0 } else { line_stop(text, head - 1) };
    let item = head + code[head..].find(|sign: char| !sign.is_whitespace() && sign != '\u{feff}')?;
    let at = above(text, item).max(head);
    let gap = if at > 0 && !text[..at].ends_with(&format!("{end}{end}")) { end } else { "" };
    Some((at, format!("{gap}{NAME}{end}{end}")))
}

/// The line by which a root names `ceid-core`, where the file uses it besides.
#[must_use]
pub fn needless_name(text: &str) -> Option<Range<usize>> {
    let at = text.find(NAME).filter(|at| begins_line(text, *at))?;
    let is_used = words(&without_comments(text), "ceid_core").nth(1).is_some();
    is_used.then(|| removal(text, at..at + NAME.len()))
}

/// Where the first `use` begins that has a line for itself and is there for nobody else.
fn first_import(text: &str) -> Option<usize> {
    let mut depth = 0;
    for token in Lexer::new(text) {
        match token.kind {
            TokenKind::Open => depth += 1,
            TokenKind::Close => depth -= 1,
            TokenKind::Word
                if depth == 0 && &text[token.start..token.end] == "use" && begins_line(text, token.start) =>
            {
                return Some(token.start);
            }
            _ => {}
        }
    }
    None
}

/// The byte behind the documentation of a file itself: `//! …`, `/*! … */`.
fn doc_comments(text: &str) -> usize {
    let is_doc = |part: &str| part.starts_with("//!") || part.starts_with("/*!");
    let head = Lexer::new(text)
        .take_while(|token| matches!(token.kind, TokenKind::Space | TokenKind::LineComment | TokenKind::BlockComment));
    head.filter(|token| is_doc(&text[token.start..token.end])).last().map_or(0, |token| token.end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: &str) {
        let mut changed = text.to_owned();
        if let Some((at, name)) = name_in_root(text) {
            changed.insert_str(at, &name);
        }
        assert_eq!(changed, expected);
    }

    #[test]
    fn it_stands_among_the_imports() {
        check("use features::A;\n\nfn main() {}\n", "use ceid_core as _;\nuse features::A;\n\nfn main() {}\n");
        check("use a::B;\nuse z::Y;\n", "use a::B;\nuse ceid_core as _;\nuse z::Y;\n");
        check(
            "//! A.\n\n// Of b.\nuse z::{\n    Y,\n};\n",
            "//! A.\n\n// Of b.\nuse z::{\n    Y,\n};\nuse ceid_core as _;\n",
        );
        check("mod a {\n    use b;\n}\n", "use ceid_core as _;\n\nmod a {\n    use b;\n}\n");
    }

    #[test]
    fn it_stands_before_all_items() {
        check("fn main() {}\n", "use ceid_core as _;\n\nfn main() {}\n");
        check(
            "//! A.\n#![no_std]\n/// B.\nfn b() {}\n",
            "//! A.\n#![no_std]\n\nuse ceid_core as _;\n\n/// B.\nfn b() {}\n",
        );
        check("//! A.\r\n\r\n#[b]\r\nfn b() {}\r\n", "//! A.\r\n\r\nuse ceid_core as _;\r\n\r\n#[b]\r\nfn b() {}\r\n");
        check("use ceid_core::{ceid, Free};\n", "use ceid_core::{ceid, Free};\n");
    }

    #[test]
    fn it_goes_where_the_file_uses_what_it_names() {
        let without = |text: &str| needless_name(text).map(|range| [&text[..range.start], &text[range.end..]].concat());
        assert_eq!(without("use ceid_core as _;\nuse ceid_core::Hz;\n").as_deref(), Some("use ceid_core::Hz;\n"));
        assert_eq!(
            without("//! A.\n\nuse ceid_core as _;\n\nceid_core::f!();\n").as_deref(),
            Some("//! A.\n\nceid_core::f!();\n")
        );
        assert_eq!(without("// ceid_core\nuse ceid_core as _;\n"), None);
    }

    #[test]
    fn a_crate_may_ask_otherwise_than_its_package() {
        assert!(asks_for_names("#![deny(unused_crate_dependencies)]\n", false));
        assert!(!asks_for_names("#![allow(unused_crate_dependencies)]\n", true));
        assert!(asks_for_names("fn main() {}\n", true) && !asks_for_names("fn main() {}\n", false));
    }
}
