//! From syn's tree to ours, one file at a time. Never drops anything in silence: what is not understood keeps the names
//! in it.

mod assoc;
pub(super) mod attrs;
mod control;
mod derived;
mod expr;
mod function;
mod items;
mod lines;
mod literal;
mod pat;
mod path;
pub(super) mod silent;
mod stmt;
mod ty;
mod uses;

use std::cell::{Cell, OnceCell};
use std::sync::Arc;

pub(super) use expr::BodyLowerer;
use syn::ext::IdentExt as _;

use self::attrs::Attrs;
use self::lines::Lines;
use super::cfg_eval::Presence;
use super::macros::Progress;
use super::modules::{LoadedFile, Loader, ModuleDir};
use super::text::{fields, mentions};
use super::tree::{Body, Item, OpaqueMacro};
use super::ways_out::ways_out;
use crate::project::CfgValues;
use crate::source::{FileId, Span};

/// Lowers one file.
pub(super) struct Lowerer<'l, 'a> {
    pub(super) loader: &'l mut Loader<'a>,
    file: FileId,
    text: Arc<str>,
    /// Where the parsed code begins in the text.
    base: usize,
    /// Made when a place is first asked for.
    lines: OnceCell<Lines>,
    dir: ModuleDir,
    /// Whether the macro or block around the items is there; they are only there if it is.
    given: Presence,
    /// How many types enclose the one that is lowered.
    type_depth: Cell<usize>,
    /// How far macros are expanded around what is lowered.
    pub(super) progress: Progress,
}

impl<'l, 'a> Lowerer<'l, 'a> {
    pub(super) fn new(loader: &'l mut Loader<'a>, file: FileId, text: Arc<str>, base: usize, dir: ModuleDir) -> Self {
        let (given, type_depth) = (Presence::Present, Cell::new(0));
        Self { loader, file, text, base, lines: OnceCell::new(), dir, given, type_depth, progress: Progress::default() }
    }

    pub(super) fn file(mut self, tree: &syn::File) -> LoadedFile {
        let attrs = self.attrs(&tree.attrs);
        let mut items = Vec::new();
        // A file that is not there declares no modules that could be missing.
        if attrs.is_there() && self.loader.keeps_items {
            self.items(&tree.items, &mut items);
        } else if attrs.is_there() {
            // Items that nobody wants are lowered for what they say of others.
            for item in &tree.items {
                self.item(item, &mut items);
                items.clear();
            }
        } else {
            tree.items.iter().for_each(|item| self.note_removed(item));
        }
        LoadedFile { attrs, items }
    }

    pub(in crate::syntax) fn cfg(&self) -> &'a CfgValues {
        self.loader.cfg
    }

    /// Our place of a token.
    pub(in crate::syntax) fn span(&self, span: proc_macro2::Span) -> Span {
        let range = self.lines.get_or_init(|| Lines::of(&self.text[self.base..])).bytes(span);
        let at = |offset: usize| u32::try_from(self.base + offset).unwrap_or(u32::MAX);
        self.progress.place(Span::new(self.file, at(range.start), at(range.end)))
    }

    pub(super) fn snippet(&self, span: Span) -> &str {
        self.text.get(span.start as usize..span.end as usize).unwrap_or("")
    }

    pub(in crate::syntax) fn opaque(&self, mac: &syn::Macro) -> OpaqueMacro {
        let delimiters = mac.delimiter.span();
        let (open, close) = (self.span(delimiters.open()), self.span(delimiters.close()));
        OpaqueMacro {
            path: path_text(&mac.path),
            span: self.path_span(&mac.path).to(close),
            tokens: Span::new(self.file, open.end, close.start),
            mentions: mentions(&mac.tokens),
            fields: fields(&mac.tokens),
            ways_out: ways_out(&mac.tokens),
        }
    }

    /// The value of a constant or static as a body without parameters.
    pub(super) fn value_body(&mut self, value: &syn::Expr) -> Body {
        let mut body = BodyLowerer::new(self);
        let root = body.expr(value);
        body.finish(root)
    }

    /// The items of a block, with modules looked for as rustc does there.
    pub(super) fn block_item(&mut self, item: &syn::Item, out: &mut Vec<Item>) {
        let block = self.dir.block();
        self.within(block, |low| low.item(item, out));
    }

    pub(super) fn within<T>(&mut self, dir: ModuleDir, work: impl FnOnce(&mut Self) -> T) -> T {
        let outer = std::mem::replace(&mut self.dir, dir);
        let value = work(self);
        self.dir = outer;
        value
    }
}

impl Lowerer<'_, '_> {
    /// Lowers what is there only if `presence` is.
    pub(in crate::syntax) fn given<T>(&mut self, presence: Presence, work: impl FnOnce(&mut Self) -> T) -> T {
        let outer = self.given.clone();
        self.given = outer.clone().and(presence);
        let value = work(self);
        self.given = outer;
        value
    }
}

impl Attrs {
    /// Whether the thing may be there.
    pub(super) fn is_there(&self) -> bool {
        self.presence != Presence::Absent
    }
}

/// A path of names as written, without spaces and arguments.
pub(in crate::syntax) fn path_text(path: &syn::Path) -> String {
    let names: Vec<String> = path.segments.iter().map(|segment| name(&segment.ident)).collect();
    let global = if path.leading_colon.is_some() { "::" } else { "" };
    format!("{global}{}", names.join("::"))
}

/// The name without `r#`.
pub(in crate::syntax) fn name(ident: &syn::Ident) -> String {
    ident.unraw().to_string()
}
