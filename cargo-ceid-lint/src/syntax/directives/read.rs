//! Finds the comments and attributes that may be directives, and what each of them stands at.

use super::grammar::{self, Said};
use super::{Directive, Site};
use crate::source::{FileId, SourceFile, Span};
use crate::syntax::lex::{Lexer, Token, TokenKind};
use crate::syntax::modules::code_start;

/// The directives of a file, in their order.
pub(super) fn directives(id: FileId, file: &SourceFile) -> Vec<Directive> {
    // Most files have none.
    if !file.text.as_bytes().windows(4).any(|word| word[0] | 0x20 == b'c' && grammar::is_prefix(word)) {
        return Vec::new();
    }
    let text = &*file.text;
    let base = code_start(text);
    let tokens: Vec<Token> = Lexer::new(&text[base..])
        .map(|token| Token { start: base + token.start, end: base + token.end, ..token })
        .filter(|token| token.kind != TokenKind::Space)
        .collect();
    let mut reader = Reader { id, text, tokens, found: Vec::new(), open: Vec::new(), code: None, pending: 0 };
    reader.read();
    reader.found
}

struct Reader<'a> {
    id: FileId,
    text: &'a str,
    tokens: Vec<Token>,
    found: Vec<Directive>,
    /// The brackets around.
    open: Vec<usize>,
    /// The first and the last token of code on the line that was reached.
    code: Option<(Token, Token)>,
    /// From where on the directives wait for the code that they stand above.
    pending: usize,
}

impl Reader<'_> {
    fn read(&mut self) {
        let mut at = 0;
        while let Some(token) = self.tokens.get(at).copied() {
            if matches!(token.kind, TokenKind::LineComment | TokenKind::BlockComment) {
                self.comment(token);
                at += 1;
            } else if let Some(end) = self.attribute_end(at) {
                self.attribute(at, end);
                at = end;
            } else {
                self.code(token);
                at += 1;
            }
        }
        self.settle(None);
    }

    fn code(&mut self, token: Token) {
        match token.kind {
            TokenKind::Close => {
                self.settle(None);
                self.open.pop();
            }
            TokenKind::Open => {
                self.settle(Some(token.start));
                self.open.push(token.start);
            }
            _ => self.settle(Some(token.start)),
        }
        self.code = match self.code {
            Some((first, last)) if !self.breaks(last.end, token.start) => Some((first, token)),
            _ => Some((token, token)),
        };
    }

    /// Gives the directives that stand above code their place.
    fn settle(&mut self, next: Option<usize>) {
        for directive in &mut self.found[self.pending..] {
            if matches!(directive.site, Site::Above(_)) {
                directive.site = Site::Above(next.map(to_u32));
            }
        }
        self.pending = self.found.len();
    }

    /// Whether a line ends between two bytes.
    fn breaks(&self, from: usize, to: usize) -> bool {
        self.text[from..to].contains('\n')
    }

    fn span(&self, start: usize, end: usize) -> Span {
        Span::new(self.id, to_u32(start), to_u32(end))
    }

    fn comment(&mut self, token: Token) {
        let text = &self.text[token.start..token.end];
        let Some(said) = (match token.kind {
            TokenKind::LineComment => grammar::line_comment(text),
            _ => grammar::block_comment(text),
        }) else {
            return;
        };
        let behind = self.code.filter(|(_, last)| !self.breaks(last.end, token.start));
        let site = match behind {
            Some((first, last)) => {
                Site::Behind { first: to_u32(first.start), last: to_u32(last.start), end: to_u32(last.end) }
            }
            None => Site::Above(None),
        };
        let end = token.start + said.end;
        let rest = &self.text[end..token.end];
        let removal = match (rest.trim().is_empty(), behind) {
            (true, None) => self.line_of(token.start, token.end),
            (true, Some(_)) => {
                let line_break = rest.len() - rest.trim_end_matches('\r').len();
                (self.text[..token.start].trim_end().len(), token.end - line_break)
            }
            // What another comment says behind it stays.
            (false, _) => (token.start, token.end - rest.trim_start().len()),
        };
        let (span, removal) = (self.span(token.start, end), self.span(removal.0, removal.1));
        self.add(said, token.start, span, removal, site);
    }

    fn add(&mut self, said: Said, base: usize, span: Span, removal: Span, site: Site) {
        let kind = said.kind(|range| self.span(base + range.start, base + range.end));
        self.found.push(Directive { span, removal, kind, site });
    }

    /// The number of the token behind the attribute that begins at one.
    fn attribute_end(&self, at: usize) -> Option<usize> {
        let word = |at: usize| self.tokens.get(at).map(|token| &self.text[token.start..token.end]);
        if word(at)? != "#" {
            return None;
        }
        let open = if word(at + 1)? == "!" { at + 2 } else { at + 1 };
        if word(open)? != "[" {
            return None;
        }
        self.closing(open).map(|close| close + 1)
    }

    /// The number of the bracket that closes one.
    fn closing(&self, open: usize) -> Option<usize> {
        let mut depth = 0usize;
        for (at, token) in self.tokens.iter().enumerate().skip(open) {
            match token.kind {
                TokenKind::Open => depth += 1,
                TokenKind::Close => {
                    depth = depth.saturating_sub(1);
                    if depth == 0 {
                        return Some(at);
                    }
                }
                _ => {}
            }
        }
        None
    }

    /// `#[cfg_attr(any(), ceid::allow(…))]`
    fn attribute(&mut self, start: usize, end: usize) {
        let tokens = &self.tokens[start..end];
        let is = |at: usize, word: &str| tokens.get(at).is_some_and(|token| &self.text[token.start..token.end] == word);
        let is_inner = is(1, "!");
        let path = if is_inner { 3 } else { 2 };
        let never = ["cfg_attr", "(", "any", "(", ")", ","];
        if !never.iter().enumerate().all(|(at, word)| is(path + at, word)) {
            return;
        }
        // Behind the list come the two closing brackets.
        let parts: Vec<(usize, usize)> = self.parts(start + path + never.len(), end - 2);
        let site = if is_inner { Site::Inside(self.open.last().copied().map(to_u32)) } else { Site::Above(None) };
        let (first, last) = (self.tokens[start].start, self.tokens[end - 1].end);
        for (number, (from, to)) in parts.iter().copied().enumerate() {
            let Some(whole) = self.text.get(from..to) else { continue };
            let text = whole.strip_prefix("ceid::");
            let base = to - text.unwrap_or(whole).len();
            let said = text.map_or_else(|| grammar::compilers_attribute(whole), grammar::attribute);
            let Some(said) = said else { continue };
            let removal = match (parts.len(), parts.get(number + 1)) {
                (1, _) => self.line_of(first, last),
                (_, Some((next, _))) => (from, *next),
                (_, None) => (parts[number - 1].1, to),
            };
            let (span, removal) = (self.span(from, to), self.span(removal.0, removal.1));
            self.add(said, base, span, removal, site);
        }
    }

    /// The parts of a list of tokens between its commas, as ranges of text.
    fn parts(&self, start: usize, end: usize) -> Vec<(usize, usize)> {
        let mut parts: Vec<(usize, usize)> = Vec::new();
        let mut depth = 0usize;
        let mut is_new = true;
        for token in self.tokens.get(start..end).unwrap_or_default() {
            match token.kind {
                TokenKind::Open => depth += 1,
                TokenKind::Close => depth = depth.saturating_sub(1),
                TokenKind::Sign if depth == 0 && &self.text[token.start..token.end] == "," => {
                    is_new = true;
                    continue;
                }
                _ => {}
            }
            match parts.last_mut() {
                Some(part) if !is_new => part.1 = token.end,
                _ => parts.push((token.start, token.end)),
            }
            is_new = false;
        }
        parts
    }

    /// The whole lines of a range, if there is nothing else on them.
    fn line_of(&self, start: usize, end: usize) -> (usize, usize) {
        let line = self.text[..start].rfind('\n').map_or(0, |at| at + 1);
        let rest = self.text[end..].find('\n').map_or(self.text.len(), |at| end + at + 1);
        let is_alone = self.text[line..start].trim().is_empty() && self.text[end..rest].trim().is_empty();
        let begins = self.text[line..start].trim().is_empty();
        let gap = self.text[end..rest].len() - self.text[end..rest].trim_start_matches([' ', '\t']).len();
        match (is_alone, begins) {
            (true, _) => (line, rest),
            // What stands behind it takes its place.
            (_, true) => (start, end + gap),
            _ => (start, end),
        }
    }
}

fn to_u32(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}
