//! Refuses texts that would need more stack than there is, by one cheap pass over their bytes. Never parses: strings,
//! characters, comments and lifetimes are skipped, everything else is brackets, words and punctuation.

use super::lex::{Lexer, Token, TokenKind};

/// How deep brackets may be nested. Hand-written code stays below 30, generated code below 100.
pub const MAX_NESTING: usize = 500;

/// How many links an expression may have, those around it included: operators, calls, prefixes, `else if`.
/// An operator or a call of a chain is two to five links, so that chains of 10,000 calls are read.
pub const MAX_LINKS: usize = 60_000;

/// Why a text is not parsed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooDeep {
    /// Where the limit is passed.
    pub offset: usize,
    /// What is too deep.
    pub what: Excess,
}

/// What is too deep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Excess {
    /// Brackets, with the depth of the deepest.
    Brackets(usize),
    /// An expression without brackets.
    Links,
}

/// Whether `text` can be parsed within the stack of [`with_large_stack`](crate::parallel::with_large_stack).
///
/// # Errors
/// Where and why it cannot.
pub fn check_depth(text: &str) -> Result<(), TooDeep> {
    let tokens = Lexer::new(text);
    let mut scan = Scan { text, tokens, levels: vec![Level::default()], total: 0, after_brace: false };
    let mut links: Option<usize> = None;
    let mut brackets: Option<usize> = None;
    let mut deepest = 0;
    while let Some(start) = scan.step() {
        if scan.levels.len() - 1 > MAX_NESTING {
            brackets.get_or_insert(start);
            deepest = deepest.max(scan.levels.len() - 1);
        }
        if scan.total > MAX_LINKS {
            links.get_or_insert(start);
        }
    }
    match (brackets, links) {
        (Some(offset), _) => Err(TooDeep { offset, what: Excess::Brackets(deepest) }),
        (None, Some(offset)) => Err(TooDeep { offset, what: Excess::Links }),
        (None, None) => Ok(()),
    }
}

/// The links of one bracket level.
#[derive(Clone, Copy, Default)]
struct Level {
    /// Since the last `,` or `;`.
    run: usize,
    /// `<` and `|` since the last `;`: a comma inside generics or closure parameters does not end what they opened.
    open: usize,
}

struct Scan<'a> {
    text: &'a str,
    tokens: Lexer<'a>,
    levels: Vec<Level>,
    total: usize,
    after_brace: bool,
}

impl Scan<'_> {
    /// Reads one token; gives where it begins, or `None` at the end.
    fn step(&mut self) -> Option<usize> {
        let Token { kind, start, end } = self.tokens.next()?;
        let bytes = &self.text.as_bytes()[start..end];
        match kind {
            TokenKind::Space | TokenKind::LineComment | TokenKind::BlockComment => return Some(start),
            TokenKind::Literal => self.add(1, 0),
            TokenKind::Open => {
                self.add(1, 0);
                self.levels.push(Level::default());
            }
            TokenKind::Close => {
                self.close();
                self.after_brace = bytes == b"}";
                return Some(start);
            }
            TokenKind::Word => self.word(bytes),
            TokenKind::Sign => match bytes {
                b"," => self.reset(false),
                b";" => self.reset(true),
                b"<" | b"|" => self.add(0, 3),
                // No expression goes on with an attribute.
                b"#" if self.after_brace => self.reset(true),
                _ => self.add(1, 0),
            },
        }
        self.after_brace = false;
        Some(start)
    }

    fn add(&mut self, run: usize, open: usize) {
        if let Some(level) = self.levels.last_mut() {
            level.run += run;
            level.open += open;
        }
        self.total += run + open;
    }

    fn reset(&mut self, all: bool) {
        if let Some(level) = self.levels.last_mut() {
            self.total -= std::mem::take(&mut level.run);
            if all {
                self.total -= std::mem::take(&mut level.open);
            }
        }
    }

    fn close(&mut self) {
        // A closing bracket too many is the parser's to report.
        if self.levels.len() > 1
            && let Some(level) = self.levels.pop()
        {
            self.total -= level.run + level.open;
        }
    }

    fn word(&mut self, word: &[u8]) {
        let goes_on = matches!(word, b"else" | b"as" | b"in");
        if self.after_brace && !goes_on {
            self.reset(true);
        }
        // These words open something that is read by recursion with the largest frames.
        let weight = match word {
            b"if" | b"match" | b"while" | b"for" | b"return" | b"break" | b"yield" | b"let" => 4,
            // The parser copies all that follows these two, each time.
            b"become" | b"box" => 60,
            b"fn" | b"impl" | b"dyn" | b"async" | b"move" | b"static" | b"const" | b"unsafe" => 2,
            _ => 1,
        };
        self.add(weight, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: Option<Excess>) {
        assert_eq!(check_depth(text).err().map(|error| error.what), expected);
    }

    #[test]
    fn nested_brackets_are_counted_to_the_deepest() {
        check(&format!("{}{}", "(".repeat(500), ")".repeat(500)), None);
        check(&format!("{}{}", "(".repeat(5000), ")".repeat(5000)), Some(Excess::Brackets(5000)));
        check(&"[{(".repeat(400), Some(Excess::Brackets(1200)));
    }

    #[test]
    fn brackets_in_text_do_not_count() {
        let open = "(".repeat(600);
        for text in [
            format!("\"\\\"{open}\""),
            format!("// {open}\n//{open}"),
            format!("/* /* {open} */ {open} */"),
            format!("r#\"{open}\"{open}\"#"),
            format!("br\"{open}\""),
            "'('".repeat(600),
            "'\\'' '\\u{28}' b'(' 'é' '('".repeat(600),
        ] {
            check(&text, None);
        }
    }

    #[test]
    fn lifetimes_do_not_open_characters() {
        check(&format!("&'a ({}", "(".repeat(600)), Some(Excess::Brackets(601)));
        check(&format!("r#if {}", "(".repeat(600)), Some(Excess::Brackets(600)));
    }

    #[test]
    fn prefixes_are_counted() {
        for prefix in ["!", "-", "&", "*", "|| ", "if ", "A<u8, ", "|a, b| ", "return ", "if a {} else "] {
            check(&prefix.repeat(100_000), Some(Excess::Links));
        }
    }

    #[test]
    fn statements_and_items_do_not_add_up() {
        for piece in [
            "a.b();",
            "if a < b { c } ",
            "fn f(a: &'a A<B>) -> C<D> { e }\n",
            "const A: B = 1;\n",
            "{ a }",
            "// a\nfn f() { a }\n",
            "/// a\nfn f() { a } // b\n",
            "fn f() { a } /* b */\n",
            "#[inline]\nfn f() { a }\n",
            "A => { b } // c\n",
        ] {
            check(&piece.repeat(50_000), None);
        }
        check(&format!("x({})", "1, ".repeat(200_000)), None);
    }

    #[test]
    fn unfinished_text_ends() {
        for text in ["\"", "'", "'\\", "r#\"", "/*", "//", "b'", "\0\0", "// \0\0", "é", "r#", "'é"] {
            check(text, None);
        }
    }
}
