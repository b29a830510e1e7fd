//! From where a directive stands to the statement, loop, function, impl or module that it stands for.

use std::collections::BTreeMap;

use rustc_hash::FxHashMap;

use super::Crate;
use crate::source::{FileId, SourceMap, Span};
use crate::syntax::tree::{AssocItem, AssocKind, Body, ExprKind, Function, Item, ItemKind, StmtKind, ValueItem};
use crate::syntax::{Directive, Site};

/// Every piece of code that a directive can stand for.
#[derive(Debug, Default)]
pub(super) struct Code {
    /// The package and target of each file.
    owners: FxHashMap<FileId, (usize, usize)>,
    /// By where they begin: the largest piece.
    pieces: BTreeMap<(FileId, u32), Span>,
    /// By where they end: the largest statement.
    ends: BTreeMap<(FileId, u32), Span>,
    /// By where the body's bracket stands: the loop or function.
    heads: FxHashMap<(FileId, u32), Span>,
    /// What modules in files of their own hold, by their declarations.
    modules: FxHashMap<Span, Vec<Span>>,
    /// The declarations of such modules.
    files: FxHashMap<FileId, Vec<Span>>,
}

impl Code {
    pub(super) fn of(crates: &[Crate<'_>]) -> Self {
        let mut code = Self::default();
        for krate in crates {
            code.items(krate.items, (krate.package, krate.target));
        }
        code
    }

    pub(super) fn owner(&self, file: FileId) -> Option<(usize, usize)> {
        self.owners.get(&file).copied()
    }

    /// The code that a directive stands for, and whether that is certain.
    pub(super) fn reach(&self, sources: &SourceMap, directive: &Directive) -> (Vec<Span>, bool) {
        let file = directive.span.file;
        match directive.site {
            // There is nothing that it could stand for.
            Site::Above(None) => (Vec::new(), true),
            Site::Above(Some(next)) => match self.piece_at(sources, file, next) {
                Some(piece) => (self.with_modules(piece), true),
                None => (vec![line_of(sources, file, next)], false),
            },
            Site::Behind { first, last, end } => {
                let mut reach = vec![line_of(sources, file, directive.span.start)];
                let piece = self.piece_at(sources, file, first);
                reach.extend(piece.into_iter().flat_map(|piece| self.with_modules(piece)));
                reach.extend(self.heads.get(&(file, last)));
                reach.extend(
                    self.pieces
                        .get(&(file, last))
                        .filter(|_| sources.file(file).text[last as usize..].starts_with('{')),
                );
                reach.extend(self.ends.get(&(file, end)));
                let is_placed = reach.len() > 1;
                (reach, is_placed)
            }
            Site::Inside(None) => {
                let text = &sources.file(file).text;
                let whole = Span::new(file, 0, u32::try_from(text.len()).unwrap_or(u32::MAX));
                let declared = self.files.get(&file).into_iter().flatten();
                let below = declared.flat_map(|declaration| self.modules.get(declaration)).flatten().copied();
                ([whole].into_iter().chain(below).collect(), true)
            }
            Site::Inside(Some(open)) => {
                // Pieces lie in each other, so that the last one that began is the innermost.
                let mut begun = self.pieces.range((file, 0)..=(file, open)).rev().map(|(_, piece)| piece);
                let piece = begun.find(|piece| open < piece.end);
                (piece.into_iter().flat_map(|piece| self.with_modules(*piece)).collect(), piece.is_some())
            }
        }
    }

    /// The largest piece of code that begins at a byte, or behind a label, a `pub` and the like that begin there.
    fn piece_at(&self, sources: &SourceMap, file: FileId, at: u32) -> Option<Span> {
        let (&(_, start), piece) = self.pieces.range((file, at)..=(file, u32::MAX)).next()?;
        let before = sources.file(file).text.get(at as usize..start as usize)?;
        is_prefix(before).then_some(*piece)
    }

    /// A piece of code with what the modules that it declares hold.
    fn with_modules(&self, piece: Span) -> Vec<Span> {
        let declared =
            self.files.get(&piece.file).into_iter().flatten().filter(|declaration| piece.contains(**declaration));
        let below = declared.flat_map(|declaration| self.modules.get(declaration)).flatten().copied();
        [piece].into_iter().chain(below).collect()
    }

    fn add(&mut self, span: Span) {
        let piece = self.pieces.entry((span.file, span.start)).or_insert(span);
        *piece = if piece.contains(span) { *piece } else { span };
    }

    fn items(&mut self, items: &[Item], owner: (usize, usize)) {
        for item in items {
            self.owners.entry(item.span.file).or_insert(owner);
            self.add(item.span);
            match &item.kind {
                ItemKind::Mod(inner) => {
                    self.items(inner, owner);
                    self.module(item.span, inner);
                }
                ItemKind::Function(function) => self.function(function, owner),
                ItemKind::Value(value) => self.value(value, owner),
                ItemKind::Trait { items, .. } | ItemKind::Impl { items, .. } => self.assoc_items(items, owner),
                ItemKind::Struct { fields, .. } => fields.fields.iter().for_each(|field| self.add(field.span)),
                ItemKind::Enum { .. }
                | ItemKind::Use(_)
                | ItemKind::ExternCrate { .. }
                | ItemKind::TypeAlias { .. }
                | ItemKind::MacroRules { .. }
                | ItemKind::MacroCall(_) => {}
            }
        }
    }

    /// What a module in another file holds, at any depth.
    fn module(&mut self, declaration: Span, inner: &[Item]) {
        let mut held: Vec<Span> =
            inner.iter().map(|item| item.span).filter(|span| span.file != declaration.file).collect();
        if held.is_empty() {
            return;
        }
        let files: std::collections::BTreeSet<FileId> = held.iter().map(|span| span.file).collect();
        let declared = files.iter().filter_map(|file| self.files.get(file)).flatten();
        let below: Vec<Span> =
            declared.filter_map(|declaration| self.modules.get(declaration)).flatten().copied().collect();
        held.extend(below);
        self.files.entry(declaration.file).or_default().push(declaration);
        self.modules.insert(declaration, held);
    }

    fn assoc_items(&mut self, items: &[AssocItem], owner: (usize, usize)) {
        for item in items {
            match &item.kind {
                AssocKind::Function(function) => self.function(function, owner),
                AssocKind::Const(value) => self.value(value, owner),
                AssocKind::Type { .. } | AssocKind::MacroCall(_) => self.add(item.name_span),
            }
        }
    }

    fn function(&mut self, function: &Function, owner: (usize, usize)) {
        let Some(body) = &function.body else {
            self.add(function.head);
            return;
        };
        let block = body.expr(body.root).span;
        let whole = function.head.to(block);
        self.add(whole);
        self.heads.insert((block.file, block.start), whole);
        self.body(body, owner);
    }

    fn value(&mut self, value: &ValueItem, owner: (usize, usize)) {
        if let Some(body) = &value.value {
            self.body(body, owner);
        }
    }

    fn body(&mut self, body: &Body, owner: (usize, usize)) {
        for expr in &body.exprs {
            self.add(expr.span);
            match &expr.kind {
                ExprKind::Block(block) => {
                    self.items(&block.items, owner);
                    for stmt in &block.stmts {
                        self.add(stmt.span);
                        let end = self.ends.entry((stmt.span.file, stmt.span.end)).or_insert(stmt.span);
                        *end = if end.contains(stmt.span) { *end } else { stmt.span };
                        if let StmtKind::Let { pat, .. } = &stmt.kind {
                            self.add(body.pat(*pat).span);
                        }
                    }
                }
                ExprKind::Loop { body: inner, .. }
                | ExprKind::While { body: inner, .. }
                | ExprKind::For { body: inner, .. } => {
                    let block = body.expr(*inner).span;
                    self.heads.insert((block.file, block.start), expr.span);
                }
                ExprKind::Match { arms, .. } => {
                    for arm in arms {
                        self.add(body.pat(arm.pat).span.to(body.expr(arm.body).span));
                    }
                }
                _ => {}
            }
        }
    }
}

/// Whether a text is only what can stand before a piece of code without being part of its place: a label, `pub(crate)`,
/// `unsafe`, an opening bracket.
fn is_prefix(text: &str) -> bool {
    let mut words =
        text.split(|letter: char| !(letter.is_alphanumeric() || letter == '_')).filter(|word| !word.is_empty());
    if let Some((label, behind)) = text.strip_prefix('\'').and_then(|text| text.split_once(':')) {
        return label.chars().all(|letter| letter.is_alphanumeric() || letter == '_') && is_prefix(behind);
    }
    let is_word = |word: &str| {
        matches!(
            word,
            "pub"
                | "crate"
                | "super"
                | "self"
                | "in"
                | "default"
                | "unsafe"
                | "async"
                | "move"
                | "const"
                | "extern"
                | "static"
                | "mut"
        )
    };
    text.chars().all(|letter| letter.is_alphanumeric() || letter.is_whitespace() || "_()&*!-\"".contains(letter))
        && words.all(is_word)
}

fn line_of(sources: &SourceMap, file: FileId, at: u32) -> Span {
    let source = sources.file(file);
    let line = sources.line(Span::new(file, at, at));
    let range = source.lines.line_range(&source.text, line);
    let to_u32 = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
    Span::new(file, to_u32(range.start), to_u32(range.end))
}
