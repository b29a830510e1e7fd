//! The code that calls stand for, lowered as if it had been written there. Never lets a macro's own variables leave it.

use proc_macro2::TokenStream;
use quote::ToTokens as _;
use syn::parse::{Parse, ParseStream, Parser as _};
use syn::visit::Visit;

use crate::source::Span;
use crate::syntax::lower::{BodyLowerer, Lowerer, path_text};
use crate::syntax::macros::duplicate;
use crate::syntax::tree::{AssocItem, Block, ExprId, ExprKind, Item, OpaqueMacro};

/// Any number of something, to the end.
struct All<T>(Vec<T>);

impl<T: Parse> Parse for All<T> {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let mut all = Vec::new();
        while !input.is_empty() {
            all.push(input.parse()?);
        }
        Ok(Self(all))
    }
}

fn parse_all<T: Parse>(tokens: TokenStream) -> Option<Vec<T>> {
    syn::parse2::<All<T>>(tokens).ok().map(|all| all.0)
}

impl<'l, 'a> Lowerer<'l, 'a> {
    /// Adds the items that a call stands for; gives false if it stays opaque.
    pub(in crate::syntax) fn own_items(&mut self, mac: &syn::Macro, out: &mut Vec<Item>) -> bool {
        let Some(items) = self.expansion(mac).and_then(parse_all::<syn::Item>) else {
            self.not_expanded(mac);
            return false;
        };
        if !self.indices_are_told_apart(mac, |search| items.iter().for_each(|item| search.visit_item(item))) {
            return false;
        }
        self.expanding(mac, |low| low.items(&items, out));
        true
    }

    /// Tells that the items are not read which one of the crate's own macros stands for, though nothing may be wrong with it: its
    /// code is longer or deeper than macros are expanded.
    fn not_expanded(&mut self, mac: &syn::Macro) {
        if self.own_rules(&mac.path).is_none() {
            return;
        }
        let OpaqueMacro { path, span, .. } = self.opaque(mac);
        let message = format!("the items that `{path}!` stands for are not read: there is too much code in them");
        let help = "a law or a cycle in them is not checked; call the macro for fewer of them at a time";
        self.loader.leave_unread(span, message, help);
    }

    /// Computed indices are told apart by their text, and those that a macro computes have none of their own.
    fn indices_are_told_apart(&self, mac: &syn::Macro, search: impl FnOnce(&mut Indices<'_, 'l, 'a>)) -> bool {
        let mut indices = Indices { low: self, call: self.opaque(mac).span, found: false };
        search(&mut indices);
        !indices.found
    }

    /// The items of an impl that a call stands for.
    pub(in crate::syntax) fn own_impl_items(&mut self, mac: &syn::Macro) -> Option<Vec<AssocItem>> {
        let Some(items) = self.expansion(mac).and_then(parse_all::<syn::ImplItem>) else {
            self.not_expanded(mac);
            return None;
        };
        let search = |search: &mut Indices<'_, '_, '_>| items.iter().for_each(|item| search.visit_impl_item(item));
        self.indices_are_told_apart(mac, search).then(|| self.expanding(mac, |low| low.impl_items(&items)))
    }

    /// The items of a trait that a call stands for.
    pub(in crate::syntax) fn own_trait_items(&mut self, mac: &syn::Macro) -> Option<Vec<AssocItem>> {
        let items = self.expansion(mac).and_then(parse_all::<syn::TraitItem>)?;
        let search = |search: &mut Indices<'_, '_, '_>| items.iter().for_each(|item| search.visit_trait_item(item));
        self.indices_are_told_apart(mac, search).then(|| self.expanding(mac, |low| low.trait_items(&items)))
    }
}

impl Lowerer<'_, '_> {
    /// Adds the items that an item with `#[duplicate_item(…)]` stands for; gives false if it has none, or is not understood.
    pub(in crate::syntax) fn duplicate_items(&mut self, item: &syn::Item, out: &mut Vec<Item>) -> bool {
        let Some(attributes) = attributes_of(item) else { return false };
        let Some((at, how)) = duplicating(attributes) else { return false };
        let mut code = item.clone();
        let own = attributes_of_mut(&mut code).map(|own| own.remove(at));
        let made = own.and_then(|_| duplicate::duplicates(&how, &code.to_token_stream()));
        let Some(items) = made.and_then(parse_all::<syn::Item>) else { return false };
        let place = self.attribute_place(&attributes[at]);
        self.duplicating(place, |low| low.items(&items, out));
        true
    }

    /// The same of an item of an impl.
    pub(in crate::syntax) fn duplicate_impl_items(&mut self, item: &syn::ImplItem) -> Option<Vec<AssocItem>> {
        let syn::ImplItem::Fn(method) = item else { return None };
        let (at, how) = duplicating(&method.attrs)?;
        let mut code = method.clone();
        code.attrs.remove(at);
        let items = duplicate::duplicates(&how, &code.to_token_stream()).and_then(parse_all::<syn::ImplItem>)?;
        let place = self.attribute_place(&method.attrs[at]);
        Some(self.duplicating(place, |low| low.impl_items(&items)))
    }

    fn attribute_place(&self, attribute: &syn::Attribute) -> Span {
        self.span(attribute.pound_token.span).to(self.span(attribute.bracket_token.span.close()))
    }

    fn duplicating<T>(&mut self, place: Span, work: impl FnOnce(&mut Self) -> T) -> T {
        self.progress.enter(place);
        let value = work(self);
        self.progress.leave();
        value
    }
}

/// The attribute that duplicates what it stands before: its number, and how.
fn duplicating(attributes: &[syn::Attribute]) -> Option<(usize, TokenStream)> {
    attributes.iter().enumerate().find_map(|(at, attribute)| {
        let last = &attribute.path().segments.last()?.ident;
        let is_it = ["duplicate_item", "substitute_item", "duplicate"].iter().any(|name| last == name);
        match &attribute.meta {
            syn::Meta::List(list) if is_it => Some((at, list.tokens.clone())),
            _ => None,
        }
    })
}

fn attributes_of(item: &syn::Item) -> Option<&[syn::Attribute]> {
    Some(match item {
        syn::Item::Fn(item) => &item.attrs,
        syn::Item::Struct(item) => &item.attrs,
        syn::Item::Enum(item) => &item.attrs,
        syn::Item::Impl(item) => &item.attrs,
        syn::Item::Trait(item) => &item.attrs,
        syn::Item::Type(item) => &item.attrs,
        syn::Item::Const(item) => &item.attrs,
        syn::Item::Static(item) => &item.attrs,
        syn::Item::Mod(item) if item.content.is_some() => &item.attrs,
        _ => return None,
    })
}

fn attributes_of_mut(item: &mut syn::Item) -> Option<&mut Vec<syn::Attribute>> {
    Some(match item {
        syn::Item::Fn(item) => &mut item.attrs,
        syn::Item::Struct(item) => &mut item.attrs,
        syn::Item::Enum(item) => &mut item.attrs,
        syn::Item::Impl(item) => &mut item.attrs,
        syn::Item::Trait(item) => &mut item.attrs,
        syn::Item::Type(item) => &mut item.attrs,
        syn::Item::Const(item) => &mut item.attrs,
        syn::Item::Static(item) => &mut item.attrs,
        syn::Item::Mod(item) => &mut item.attrs,
        _ => return None,
    })
}

/// Looks for computed indices whose text is that of the whole call.
struct Indices<'s, 'l, 'a> {
    low: &'s Lowerer<'l, 'a>,
    call: Span,
    found: bool,
}

impl<'e> Visit<'e> for Indices<'_, '_, '_> {
    fn visit_expr_index(&mut self, expr: &'e syn::ExprIndex) {
        let index = ungrouped(&expr.index);
        let is_told = match index {
            syn::Expr::Lit(_) | syn::Expr::Path(_) | syn::Expr::Range(_) => true,
            _ => is_variable(index),
        };
        if !is_told {
            let mut tokens = index.to_token_stream().into_iter();
            self.found |= tokens.any(|token| self.low.span(token.span()) == self.call);
        }
        syn::visit::visit_expr_index(self, expr);
    }
}

/// An expression without what only holds it together.
fn ungrouped(mut expr: &syn::Expr) -> &syn::Expr {
    while let syn::Expr::Group(syn::ExprGroup { expr: inner, .. })
    | syn::Expr::Paren(syn::ExprParen { expr: inner, .. }) = expr
    {
        expr = inner;
    }
    expr
}

/// Whether an index is a variable, whatever number type it is made: `i as usize`, `*i`.
fn is_variable(index: &syn::Expr) -> bool {
    match ungrouped(index) {
        syn::Expr::Cast(cast) => is_variable(&cast.expr),
        syn::Expr::Unary(syn::ExprUnary { op: syn::UnOp::Deref(_), expr, .. }) => is_variable(expr),
        syn::Expr::Path(path) => {
            path.path.get_ident().is_some_and(|name| name.to_string().starts_with(char::is_lowercase))
        }
        _ => false,
    }
}

/// The statements that a call stands for.
pub(in crate::syntax) struct OwnStmts {
    pub(in crate::syntax) stmts: Vec<syn::Stmt>,
    /// Whether they declare something that the code behind the call can use: items, and variables that the call names.
    pub(in crate::syntax) declares: bool,
}

impl BodyLowerer<'_, '_, '_> {
    /// A call where an expression stands; `None` if it stays opaque.
    pub(in crate::syntax) fn own_expr(&mut self, mac: &syn::Macro) -> Option<ExprId> {
        let tokens = self.low.expansion(mac)?;
        if let Ok(expr) = syn::parse2::<syn::Expr>(tokens.clone()) {
            let is_plain = self.low.indices_are_told_apart(mac, |search| search.visit_expr(&expr));
            return is_plain.then(|| self.expanding(mac, |body| body.expr(&expr)));
        }
        let stmts = self.parsed_stmts(mac, tokens)?;
        Some(self.own_block(mac, stmts))
    }

    /// A call where a statement stands; `None` if it stays opaque.
    pub(in crate::syntax) fn own_stmts(&mut self, mac: &syn::Macro) -> Option<OwnStmts> {
        let tokens = self.low.expansion(mac)?;
        let stmts = self.parsed_stmts(mac, tokens)?;
        let call = self.low.opaque(mac).span;
        let mut declares = false;
        let mut may_declare = false;
        let mut has_own = false;
        for stmt in &stmts {
            match stmt {
                syn::Stmt::Item(_) => declares = true,
                syn::Stmt::Local(local) => {
                    let mut names = Vec::new();
                    bound_names(&local.pat, &mut names);
                    let is_given = names.iter().any(|ident| self.span(ident.span()) != call);
                    declares |= is_given;
                    has_own |= !is_given;
                }
                // Another macro may declare something with what it is given.
                syn::Stmt::Macro(inner) => may_declare |= self.low.own_rules(&inner.mac.path).is_some(),
                syn::Stmt::Expr(..) => {}
            }
        }
        declares |= may_declare && !has_own;
        Some(OwnStmts { stmts, declares })
    }

    fn parsed_stmts(&self, mac: &syn::Macro, tokens: TokenStream) -> Option<Vec<syn::Stmt>> {
        let stmts = syn::Block::parse_within.parse2(tokens).ok()?;
        let search = |search: &mut Indices<'_, '_, '_>| stmts.iter().for_each(|stmt| search.visit_stmt(stmt));
        self.low.indices_are_told_apart(mac, search).then_some(stmts)
    }

    /// The block that a call stands for.
    pub(in crate::syntax) fn own_block(&mut self, mac: &syn::Macro, stmts: Vec<syn::Stmt>) -> ExprId {
        let span = self.low.opaque(mac).span;
        let block = syn::Block { brace_token: syn::token::Brace::default(), stmts };
        self.expanding(mac, |body| {
            if let [syn::Stmt::Expr(expr, _)] = block.stmts.as_slice() {
                return body.expr(expr);
            }
            let lowered: Block = body.block(&block);
            body.add(ExprKind::Block(lowered), span)
        })
    }

    /// Lowers the code that a call stands for.
    pub(in crate::syntax) fn expanding<T>(&mut self, mac: &syn::Macro, work: impl FnOnce(&mut Self) -> T) -> T {
        let call = self.low.opaque(mac).span;
        let from = self.number_of_exprs();
        self.low.progress.enter(call);
        let value = work(self);
        self.low.progress.leave();
        self.note_written_again(from, call, &path_text(&mac.path));
        value
    }
}

fn bound_names<'p>(pat: &'p syn::Pat, names: &mut Vec<&'p syn::Ident>) {
    struct Names<'v, 'p>(&'v mut Vec<&'p syn::Ident>);
    impl<'p> Visit<'p> for Names<'_, 'p> {
        fn visit_pat_ident(&mut self, ident: &'p syn::PatIdent) {
            self.0.push(&ident.ident);
            syn::visit::visit_pat_ident(self, ident);
        }
    }
    Names(names).visit_pat(pat);
}
