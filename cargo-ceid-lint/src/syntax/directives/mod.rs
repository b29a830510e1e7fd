//! What `ceid:` comments and `ceid::` attributes say, and where they stand. Never reads one out of a string, out of
//! documentation or out of prose, and never judges whether a rule of that name exists.

mod grammar;
mod read;

use std::collections::BTreeMap;

use crate::source::{FileId, SourceMap, Span};
use crate::syntax::lex::{Lexer, TokenKind};

/// The directives of all files.
#[derive(Clone, Debug, Default)]
pub struct Directives {
    files: BTreeMap<FileId, Vec<Directive>>,
    cycles: BTreeMap<FileId, BTreeMap<u32, OfLine>>,
}

/// What is said of the code of a line.
#[derive(Clone, Copy, Debug)]
struct OfLine {
    said: CycleDirective,
    /// Where the code begins that it is said of, if that is the first loop, function or gate from there on.
    from: Option<u32>,
}

/// A directive, or what was meant as one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Directive {
    /// The comment, or the attribute's part that says it.
    pub span: Span,
    /// What goes when it is removed: the whole line, if it is alone there.
    pub removal: Span,
    /// What it says.
    pub kind: DirectiveKind,
    /// Where it stands.
    pub site: Site,
}

/// What a directive says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DirectiveKind {
    /// What a loop, function or gate is.
    Cycle(CycleDirective),
    /// That a finding is known.
    Suppression(Suppression),
    /// Nearly a directive.
    NearMiss(NearMiss),
}

/// What a comment says of a loop, function or gate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CycleDirective {
    /// `// ceid: cycle`
    Cycle,
    /// `// ceid: not-a-cycle`
    NotACycle,
    /// `// ceid: every(10)`: what follows updates in one of so many cycles.
    Every(u64),
}

/// `allow(rule, reason = "…")`, `expect(rule, reason = "…")`
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Suppression {
    /// Whether it says that a finding is there: `expect`.
    pub is_expected: bool,
    /// The names of the rules, as written, with their places.
    pub rules: Vec<(String, Span)>,
    /// Why.
    pub reason: Option<String>,
}

/// What was meant as a directive and is none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NearMiss {
    /// What is wrong with it; lower case, no full stop.
    pub message: String,
    /// What to write, and where, if that is known.
    pub correction: Option<(Span, String)>,
    /// Whether the correction can only be what was meant, and hides no finding.
    pub is_certain: bool,
}

/// Where a directive stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Site {
    /// Above what begins at this byte; `None` if nothing follows in the same brackets.
    Above(Option<u32>),
    /// At the end of a line of code.
    Behind {
        /// Where the first token of the line begins.
        first: u32,
        /// Where the last one begins.
        last: u32,
        /// Where the last one ends.
        end: u32,
    },
    /// An inner attribute: what the bracket at this byte encloses, or the file.
    Inside(Option<u32>),
}

impl Directives {
    /// Reads the directives of all files.
    #[must_use]
    pub fn read(sources: &SourceMap) -> Self {
        let mut directives = Self::default();
        for (id, file) in sources.files() {
            let found = read::directives(id, file);
            if !found.is_empty() {
                directives.cycles.insert(id, of_cycles(id, sources, &found));
                directives.files.insert(id, found);
            }
        }
        directives
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.files.is_empty()
    }

    /// All of them, by file and place.
    pub fn iter(&self) -> impl Iterator<Item = &Directive> {
        self.files.values().flatten()
    }

    /// What a comment above the line of a place, or at its end, says of the cycle or gate there.
    #[must_use]
    pub fn of_cycle(&self, sources: &SourceMap, place: Span) -> Option<CycleDirective> {
        let own = self.cycles.get(&place.file)?;
        let of_line = own.get(&sources.line(place))?;
        let text = &sources.file(place.file).text;
        let before = of_line.from.and_then(|from| text.get(from as usize..place.start as usize));
        (!before.is_some_and(enters_body)).then_some(of_line.said)
    }
}

/// Whether the body of a function or loop begins in a piece of a line, so that what follows lies in it.
fn enters_body(text: &str) -> bool {
    let mut is_impl = false;
    let mut is_head = false;
    for token in Lexer::new(text) {
        match (token.kind, &text[token.start..token.end]) {
            (TokenKind::Word, "impl") => is_impl = true,
            // `impl Trait for Type`
            (TokenKind::Word, "for") => is_head |= !is_impl,
            (TokenKind::Word, "fn" | "loop" | "while") => is_head = true,
            (TokenKind::Open, "{") if is_head => return true,
            _ => {}
        }
    }
    false
}

/// What the comments of a file say of cycles, by the lines of what they stand at; the last one of each.
fn of_cycles(id: FileId, sources: &SourceMap, found: &[Directive]) -> BTreeMap<u32, OfLine> {
    let line_of = |at: u32| sources.line(Span::new(id, at, at));
    let of_directive = |directive: &Directive| {
        let DirectiveKind::Cycle(said) = directive.kind else { return None };
        match directive.site {
            Site::Above(Some(next)) => Some((line_of(next), OfLine { said, from: Some(next) })),
            Site::Behind { .. } => Some((line_of(directive.span.start), OfLine { said, from: None })),
            Site::Above(None) | Site::Inside(_) => None,
        }
    };
    found.iter().filter_map(of_directive).collect()
}

#[cfg(test)]
mod tests;
