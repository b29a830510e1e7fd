//! Files that a text names: `#[path = "…"]` and `include!("…")`. Never parses: where the name cannot be read from the bytes
//! alone, it is unknown.

use std::path::{Component, Path, PathBuf};

use memchr::memmem;

use crate::syntax::{Lexer, TokenKind};

/// A file that may be a part of a crate although it does not lie where modules lie.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Link {
    /// This one.
    To(PathBuf),
    /// Any.
    Unknown,
}

/// The links in the text of the file at `path` that lead out of the usual places.
pub(super) fn links(path: &Path, text: &[u8]) -> Vec<Link> {
    let directory = path.parent().unwrap_or(Path::new(""));
    let mut found = Vec::new();
    for at in memmem::find_iter(text, "include!") {
        if at.checked_sub(1).is_none_or(|before| !is_word(text[before])) {
            let rest = skip(&text[at + "include!".len()..], b" \t\r\n([{");
            // A path that is put together is not followed.
            if let Some(b'"' | b'r' | b'$') = rest.first() {
                found.push((at, link(directory, rest)));
            }
        }
    }
    for at in memmem::find_iter(text, "path") {
        let rest = skip(&text[at + "path".len()..], b" \t\r\n");
        if rest.first() == Some(&b'=') && rest.get(1) != Some(&b'=') && is_attribute(&text[..at]) {
            found.push((at, link(directory, skip(&rest[1..], b" \t\r\n"))));
        }
    }
    if !found.is_empty() {
        retain_code(text, &mut found);
    }
    found.into_iter().map(|(_, link)| link).collect()
}

/// Leaves out what stands in a comment or in a literal: tests of tools for Rust are full of such texts.
fn retain_code(text: &[u8], found: &mut Vec<(usize, Link)>) {
    let Ok(text) = std::str::from_utf8(text) else { return };
    let is_code = |kind| !matches!(kind, TokenKind::LineComment | TokenKind::BlockComment | TokenKind::Literal);
    found.sort_by_key(|(at, _)| *at);
    let mut tokens = Lexer::new(text).peekable();
    found.retain(|(at, _)| {
        while tokens.next_if(|token| token.end <= *at).is_some() {}
        tokens.peek().is_none_or(|token| is_code(token.kind))
    });
}

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_' || byte >= 0x80
}

fn skip<'a>(text: &'a [u8], bytes: &[u8]) -> &'a [u8] {
    let length = text.iter().position(|byte| !bytes.contains(byte)).unwrap_or(text.len());
    &text[length..]
}

/// Whether an attribute is open at the end of the text: `#[`, or `#[cfg_attr(unix, `.
fn is_attribute(before: &[u8]) -> bool {
    const FAR: usize = 400;
    let before = &before[before.len().saturating_sub(FAR)..];
    let Some(end) = before.iter().rposition(|byte| !byte.is_ascii_whitespace()) else { return false };
    match before[end] {
        b'[' | b'/' => true,
        b',' => memmem::rfind(before, b"cfg_attr").is_some(),
        _ => false,
    }
}

/// What a literal leads to.
fn link(directory: &Path, text: &[u8]) -> Link {
    let Some(literal) = text.strip_prefix(b"\"") else { return Link::Unknown };
    let end = literal.iter().position(|byte| matches!(byte, b'"' | b'\\' | b'\n'));
    let Some(literal) = end.filter(|end| literal[*end] == b'"').map(|end| &literal[..end]) else {
        return Link::Unknown;
    };
    let Ok(literal) = std::str::from_utf8(literal) else { return Link::Unknown };
    let mut plain = PathBuf::new();
    for part in directory.join(literal).components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => {
                plain.pop();
            }
            other => plain.push(other),
        }
    }
    let is_hidden = Path::new(literal).components().any(|part| match part {
        Component::Normal(name) => {
            name == "target" || name == "node_modules" || name.to_string_lossy().starts_with('.')
        }
        _ => false,
    });
    if is_hidden { Link::Unknown } else { Link::To(plain) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: &[Link]) {
        assert_eq!(links(Path::new("/ws/a/src/lib.rs"), text.as_bytes()), expected);
    }

    fn to(path: &str) -> Link {
        Link::To(PathBuf::from(path))
    }

    #[test]
    fn attributes_and_includes_are_links() {
        check("#[path = \"x.rs\"] mod x;", &[to("/ws/a/src/x.rs")]);
        check("#[cfg_attr(unix, path=\"../../b/x.rs\")] mod x;", &[to("/ws/b/x.rs")]);
        check("include!(\"../shared.rs\");", &[to("/ws/a/shared.rs")]);
        check("include! { \"x.rs\" }", &[to("/ws/a/src/x.rs")]);
        check("/*\n// */ include!(\"parts.inc\");", &[to("/ws/a/src/parts.inc")]);
    }

    #[test]
    fn what_cannot_be_read_is_unknown() {
        for text in ["#[path = $p] mod x;", "include!($p);", "include!(r\"x.rs\");"] {
            check(text, &[Link::Unknown]);
        }
        check("#[path = \".hidden/x.rs\"] mod x;", &[Link::Unknown]);
        check("#[path = /* here */ \"x.rs\"] mod x;", &[Link::Unknown]);
        // What looks like a comment is the end of a longer one, or of a string.
        check("/*\n// */ include!($p);", &[Link::Unknown]);
        check("const A: &str = \"\n// \"; include!($p);", &[Link::Unknown]);
    }

    #[test]
    fn other_words_are_no_links() {
        for text in [
            "let path = \"a.rs\";",
            "include_str!(\"a.md\")",
            "include!(concat!(env!(\"OUT_DIR\"), \"/a.rs\"));",
            "//! a = { path = \"../a\" }",
            "if path == \"a\" {}",
            "/// # include!(\"../../setup.rs\");",
            "fn f() {}\n    //! #[path = \"../parts/x.rs\"] mod x;",
            "check(r#\"\n#[path = \"../x.rs\"] mod x;\n\"#);",
            "check(\"\ninclude!($p);\n\");",
        ] {
            check(text, &[]);
        }
    }
}
