//! The statement that a finding is shown at, with the block, the body and the text around it.

use std::cell::RefCell;
use std::cmp::Reverse;
use std::ops::Range;
use std::rc::Rc;

use rustc_hash::FxHashMap;

use crate::diagnostic::{Applicability, Suggestion};
use crate::flow::Program;
use crate::index::{FunctionId, ModuleId};
use crate::source::{FileId, Span};
use crate::syntax::tree::{Block, Body, ExprId, ExprKind, Stmt};
use crate::syntax::{Outline, Token};
use crate::types::TypedBody;

use super::words::{code, mentions};

/// A statement in its surroundings. It is written where it stands, and it is there under every `cfg`.
pub(super) struct Site<'a> {
    pub(super) program: &'a Program<'a>,
    pub(super) file: FileId,
    /// The whole file.
    pub(super) text: &'a str,
    tokens: Rc<[Token]>,
    outline: Rc<Outline>,
    /// The function, from its head to its end.
    pub(super) function: Range<usize>,
    /// The module that it is declared in.
    pub(super) module: ModuleId,
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

/// What is asked of files for every finding in them, and read once.
pub(super) struct Places<'a> {
    program: &'a Program<'a>,
    /// The functions of each file, by where they begin; of those that begin at one place, the innermost last.
    functions: FxHashMap<FileId, Vec<Function>>,
    texts: RefCell<FxHashMap<FileId, Text>>,
}

/// A text as tokens and as brackets.
type Text = (Rc<[Token]>, Rc<Outline>);

struct Function {
    whole: Span,
    id: FunctionId,
    /// The furthest end of the functions up to this one.
    furthest: u32,
}

impl<'a> Places<'a> {
    pub(super) fn of(program: &'a Program<'a>) -> Self {
        let mut functions: FxHashMap<FileId, Vec<Function>> = FxHashMap::default();
        for id in program.index.function_ids() {
            let function = &program.index.function(id).function;
            let Some(body) = &function.body else { continue };
            let whole = function.head.to(body.expr(body.root).span);
            functions.entry(whole.file).or_default().push(Function { whole, id, furthest: whole.end });
        }
        #[expect(clippy::iter_over_hash_type, reason = "each file is put in order by itself")]
        for list in functions.values_mut() {
            list.sort_by_key(|own| (own.whole.start, Reverse((own.whole.end, own.id))));
            let mut furthest = 0;
            for own in list {
                furthest = own.whole.end.max(furthest);
                own.furthest = furthest;
            }
        }
        Self { program, functions, texts: RefCell::default() }
    }

    /// The innermost function around a place.
    fn function(&self, place: Span) -> Option<&Function> {
        let list = self.functions.get(&place.file)?;
        let before = &list[..list.partition_point(|own| own.whole.start <= place.start)];
        let near = before.iter().rev().take_while(|own| own.furthest >= place.end);
        near.into_iter().find(|own| own.whole.contains(place))
    }

    fn text(&self, file: FileId, text: &str) -> Text {
        let read = || (code(text, 0..text.len()).into(), Rc::new(Outline::of(text)));
        let mut texts = self.texts.borrow_mut();
        let (tokens, outline) = texts.entry(file).or_insert_with(read);
        (Rc::clone(tokens), Rc::clone(outline))
    }
}

pub(super) fn bytes(span: Span) -> Range<usize> {
    span.start as usize..span.end as usize
}

impl<'a> Site<'a> {
    /// The innermost statement around a place.
    pub(super) fn of(places: &Places<'a>, place: Span) -> Option<Self> {
        let program = places.program;
        let Function { whole, id, .. } = *places.function(place)?;
        let body = program.index.function(id).function.body.as_ref()?;
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
        let (tokens, outline) = places.text(place.file, text);
        let site = Self {
            program,
            file: place.file,
            text,
            tokens,
            outline,
            function: bytes(whole),
            module: program.index.function(id).module,
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
        self.outline.around(at).any(|around| around.is_macro)
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
