//! The statement that a finding is shown at, with the block, the body and the text around it.

use std::cell::RefCell;
use std::collections::HashMap;
use std::ops::Range;
use std::rc::Rc;

use crate::diagnostic::{Applicability, Suggestion};
use crate::flow::Program;
use crate::source::{FileId, Span};
use crate::syntax::Token;
use crate::syntax::tree::{Block, Body, ExprId, ExprKind, Stmt};
use crate::types::TypedBody;

use super::words::{code, is_in_macro, mentions};

/// A statement in its surroundings. It is written where it stands, and it is there under every `cfg`.
pub(super) struct Site<'a> {
    pub(super) program: &'a Program<'a>,
    pub(super) file: FileId,
    /// The whole file.
    pub(super) text: &'a str,
    tokens: Rc<[Token]>,
    /// The function, from its head to its end.
    pub(super) function: Range<usize>,
    pub(super) body: &'a Body,
    pub(super) typed: &'a TypedBody,
    /// The innermost block around the statement, and its braces.
    pub(super) block: &'a Block,
    pub(super) braces: Range<usize>,
    /// The number of the statement in the block.
    pub(super) at: usize,
    /// The place that was looked for.
    pub(super) place: Span,
}

/// The tokens of files, each of which is read once for all findings in it.
#[derive(Default)]
pub(super) struct Tokens(RefCell<HashMap<FileId, Rc<[Token]>>>);

impl Tokens {
    fn of(&self, file: FileId, text: &str) -> Rc<[Token]> {
        Rc::clone(self.0.borrow_mut().entry(file).or_insert_with(|| code(text, 0..text.len()).into()))
    }
}

pub(super) fn bytes(span: Span) -> Range<usize> {
    span.start as usize..span.end as usize
}

impl<'a> Site<'a> {
    /// The innermost statement around a place.
    pub(super) fn of(program: &'a Program<'a>, tokens: &Tokens, place: Span) -> Option<Self> {
        let functions = program.index.function_ids().filter_map(|id| {
            let function = &program.index.function(id).function;
            let body = function.body.as_ref()?;
            let whole = function.head.to(body.expr(body.root).span);
            whole.contains(place).then_some((id, whole, body))
        });
        let (id, whole, body) = functions.min_by_key(|(_, whole, _)| whole.end - whole.start)?;
        let mut found: Option<(u32, &Block, Span, usize)> = None;
        for expr in &body.exprs {
            let ExprKind::Block(block) = &expr.kind else { continue };
            for (at, stmt) in block.stmts.iter().enumerate().filter(|(_, stmt)| stmt.span.contains(place)) {
                let length = stmt.span.end - stmt.span.start;
                if found.is_none_or(|(shortest, ..)| length < shortest) {
                    found = Some((length, block, expr.span, at));
                }
            }
        }
        let (_, block, braces, at) = found?;
        let text = &program.sources.file(place.file).text;
        let site = Self {
            program,
            file: place.file,
            text,
            tokens: tokens.of(place.file, text),
            function: bytes(whole),
            body,
            typed: program.typed(id)?,
            block,
            braces: bytes(braces),
            at,
            place,
        };
        (text.get(bytes(braces))?.starts_with('{') && site.is_plain(site.stmt())).then_some(site)
    }

    pub(super) fn stmt(&self) -> &'a Stmt {
        &self.block.stmts[self.at]
    }

    /// Whether a statement is written where it stands, without attributes.
    pub(super) fn is_plain(&self, stmt: &Stmt) -> bool {
        let start = stmt.span.start as usize;
        let follows = || self.before(start).last().is_some_and(|last| self.text[..last.end].ends_with([';', '{', '}']));
        stmt.cfg.is_none() && stmt.span.file == self.file && follows() && !self.is_in_macro(start)
    }

    /// The tokens of the file before a place.
    fn before(&self, at: usize) -> &[Token] {
        &self.tokens[..self.tokens.partition_point(|token| token.end <= at)]
    }

    /// Whether a place stands in the tokens of a macro.
    pub(super) fn is_in_macro(&self, at: usize) -> bool {
        is_in_macro(self.text, self.before(at))
    }

    /// The text of a place.
    pub(super) fn snippet(&self, span: Span) -> &'a str {
        self.text.get(bytes(span)).unwrap_or_default()
    }

    /// The text of an expression without white space.
    pub(super) fn spelled(&self, id: ExprId) -> String {
        self.snippet(self.body.expr(id).span).split_whitespace().collect()
    }

    pub(super) fn span(&self, range: Range<usize>) -> Span {
        let offset = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
        Span::new(self.file, offset(range.start), offset(range.end))
    }

    pub(super) fn suggestion(
        &self,
        message: String,
        edits: Vec<(Range<usize>, String)>,
        applicability: Applicability,
    ) -> Suggestion {
        let edits = edits.into_iter().map(|(range, text)| (self.span(range), text)).collect();
        Suggestion { message, edits, applicability }
    }

    /// The first of these names that the function does not mention, but for methods and fields.
    pub(super) fn free_name(&self, names: &[&'static str]) -> Option<&'static str> {
        names.iter().find(|name| mentions(self.text, self.function.clone(), name).is_empty()).copied()
    }
}
