//! Text as raw tokens: comments, literals, words, brackets, signs. Never fails, and allocates nothing.

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TokenKind {
    /// White space.
    Space,
    /// `// …`, documentation included.
    LineComment,
    /// `/* … */`, documentation included.
    BlockComment,
    /// A string without prefix, a raw string with its prefix, or a character.
    Literal,
    /// A word, a number, or the prefix of a string.
    Word,
    /// An opening bracket.
    Open,
    /// A closing bracket.
    Close,
    /// A sign; the quote of a lifetime is one.
    Sign,
}

/// A piece of text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Token {
    /// What it is.
    pub(crate) kind: TokenKind,
    /// Its first byte.
    pub(crate) start: usize,
    /// The byte behind its last one.
    pub(crate) end: usize,
}

/// The tokens of a text, without gaps.
pub(crate) struct Lexer<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Lexer<'a> {
    pub(crate) fn new(text: &'a str) -> Self {
        Self { bytes: text.as_bytes(), at: 0 }
    }

    fn peek(&self, ahead: usize) -> u8 {
        self.bytes.get(self.at + ahead).copied().unwrap_or(0)
    }

    /// Goes on while the bytes are of a kind.
    fn skip(&mut self, is_such: impl Fn(u8) -> bool) {
        let rest = &self.bytes[self.at..];
        self.at += rest.iter().position(|byte| !is_such(*byte)).unwrap_or(rest.len());
    }

    fn line_comment(&mut self) -> TokenKind {
        let rest = &self.bytes[self.at..];
        self.at += memchr::memchr(b'\n', rest).unwrap_or(rest.len());
        TokenKind::LineComment
    }

    fn block_comment(&mut self) -> TokenKind {
        self.at += 1;
        let mut depth = 1;
        while depth > 0 && self.at < self.bytes.len() {
            match (self.peek(0), self.peek(1)) {
                (b'/', b'*') => {
                    depth += 1;
                    self.at += 2;
                }
                (b'*', b'/') => {
                    depth -= 1;
                    self.at += 2;
                }
                _ => self.at += 1,
            }
        }
        TokenKind::BlockComment
    }

    /// The rest of a string with escapes.
    fn string(&mut self) -> TokenKind {
        while let Some(rest) = self.bytes.get(self.at..) {
            let Some(end) = memchr::memchr2(b'"', b'\\', rest) else {
                self.at = self.bytes.len();
                break;
            };
            self.at += end + 1;
            if rest[end] == b'"' {
                break;
            }
            self.at += 1;
        }
        TokenKind::Literal
    }

    /// A character, or the quote of a lifetime.
    fn quote(&mut self) -> TokenKind {
        if self.peek(0) == b'\\' {
            self.at += 2;
            while self.at < self.bytes.len() && !matches!(self.peek(0), b'\'' | b'\n') {
                self.at += 1;
            }
            self.at += 1;
            return TokenKind::Literal;
        }
        let width = match self.peek(0) {
            0..=0x7f => 1,
            0x80..=0xdf => 2,
            0xe0..=0xef => 3,
            0xf0.. => 4,
        };
        if self.peek(width) == b'\'' {
            self.at += width + 1;
            return TokenKind::Literal;
        }
        TokenKind::Sign
    }

    /// A word, number or raw string.
    fn word(&mut self, start: usize) -> TokenKind {
        self.skip(is_of_word);
        let is_raw = matches!(&self.bytes[start..self.at], b"r" | b"br" | b"cr") && self.raw_string();
        if is_raw { TokenKind::Literal } else { TokenKind::Word }
    }

    /// The rest of `r"…"` or `r#"…"#`; gives false if it is something else.
    fn raw_string(&mut self) -> bool {
        let mut hashes = 0;
        while self.peek(hashes) == b'#' {
            hashes += 1;
        }
        if self.peek(hashes) != b'"' {
            return false;
        }
        self.at += hashes + 1;
        while self.at < self.bytes.len() {
            self.at += 1;
            if self.bytes[self.at - 1] == b'"' && (0..hashes).all(|hash| self.peek(hash) == b'#') {
                self.at += hashes;
                break;
            }
        }
        true
    }
}

impl Iterator for Lexer<'_> {
    type Item = Token;

    fn next(&mut self) -> Option<Token> {
        let start = self.at;
        let byte = *self.bytes.get(start)?;
        self.at += 1;
        let kind = match byte {
            _ if byte.is_ascii_whitespace() => {
                self.skip(|byte| byte.is_ascii_whitespace());
                TokenKind::Space
            }
            b'/' if self.peek(0) == b'/' => self.line_comment(),
            b'/' if self.peek(0) == b'*' => self.block_comment(),
            b'"' => self.string(),
            b'\'' => self.quote(),
            b'(' | b'[' | b'{' => TokenKind::Open,
            b')' | b']' | b'}' => TokenKind::Close,
            _ if is_of_word(byte) => self.word(start),
            _ => TokenKind::Sign,
        };
        self.at = self.at.min(self.bytes.len());
        Some(Token { kind, start, end: self.at })
    }
}

/// Which bytes words and numbers are made of: every byte of a file is asked for, some more than once.
static OF_WORD: [bool; 256] = {
    let mut table = [false; 256];
    let mut byte = 0u8;
    loop {
        table[byte as usize] = byte.is_ascii_alphanumeric() || byte == b'_' || !byte.is_ascii();
        if byte == u8::MAX {
            break table;
        }
        byte += 1;
    }
};

fn is_of_word(byte: u8) -> bool {
    OF_WORD[usize::from(byte)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: &[(TokenKind, &str)]) {
        let tokens: Vec<(TokenKind, &str)> = Lexer::new(text)
            .filter(|token| token.kind != TokenKind::Space)
            .map(|token| (token.kind, &text[token.start..token.end]))
            .collect();
        assert_eq!(tokens, expected);
    }

    #[test]
    fn comments_in_strings_are_no_comments() {
        use TokenKind::{LineComment, Literal, Sign, Word};
        check(r#""// a" // b"#, &[(Literal, "\"// a\""), (LineComment, "// b")]);
        check("r#\"// \"a\"# x", &[(Literal, "r#\"// \"a\"#"), (Word, "x")]);
        check("'\"' // b", &[(Literal, "'\"'"), (LineComment, "// b")]);
        check("'a: // b", &[(Sign, "'"), (Word, "a"), (Sign, ":"), (LineComment, "// b")]);
    }

    #[test]
    fn tokens_leave_no_gap() {
        for text in ["a\u{301}(\"\\", "'\\", "/* /* */ x", "\u{feff}#!/x//y\nfn", "r##\"a\"#", "b'x' 'é' \u{a0}"] {
            let mut at = 0;
            for token in Lexer::new(text) {
                assert_eq!(token.start, at);
                at = token.end;
                assert!(text.is_char_boundary(at), "{text:?} at {at}");
            }
            assert_eq!(at, text.len());
        }
    }
}
