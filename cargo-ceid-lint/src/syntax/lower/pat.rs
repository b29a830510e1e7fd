//! Patterns, and the parameters made of them. Never tells constants from bindings: the index does.

use proc_macro2::{TokenStream, TokenTree};
use quote::ToTokens as _;
use syn::parse::Parser as _;
use syn::spanned::Spanned as _;

use super::BodyLowerer;
use super::expr::member;
use super::name;
use crate::syntax::text::tokens_text;
use crate::syntax::tree::{PatId, PatKind};

impl BodyLowerer<'_, '_, '_> {
    pub(super) fn self_param(&mut self, receiver: &syn::Receiver) {
        let mutable = receiver.mutability.is_some();
        let kind = PatKind::Bind { name: "self".to_owned(), by_ref: false, mutable, sub: None };
        let span = self.span(receiver.self_token.span);
        let pat = self.add_pat(kind, span);
        self.add_param(pat);
    }

    pub(super) fn param(&mut self, param: &syn::PatType) {
        if self.low.cfg_key(&param.attrs).is_some() {
            let pat = self.pat(&param.pat);
            self.add_param(pat);
        }
    }

    pub(in crate::syntax) fn pat(&mut self, pat: &syn::Pat) -> PatId {
        match pat {
            syn::Pat::Paren(paren) => self.pat(&paren.pat),
            syn::Pat::Ident(ident) => self.bind(ident),
            syn::Pat::Wild(wild) => {
                let span = self.span(wild.underscore_token.span);
                self.add_pat(PatKind::Wild, span)
            }
            syn::Pat::Rest(rest) => {
                let span = self.span(rest.dot2_token.spans[0]).to(self.span(rest.dot2_token.spans[1]));
                self.add_pat(PatKind::Rest, span)
            }
            syn::Pat::Path(path) => {
                let span = self.low.qualified_span(path.qself.as_ref(), &path.path);
                let path = self.low.path(path.qself.as_ref(), &path.path);
                self.add_pat(PatKind::Path(path), span)
            }
            syn::Pat::Tuple(tuple) => {
                let elements = self.pats(&tuple.elems);
                let span = self.span(tuple.paren_token.span.join());
                self.add_pat(PatKind::Tuple(elements), span)
            }
            syn::Pat::TupleStruct(tuple) => self.tuple_struct(tuple),
            syn::Pat::Struct(fields) => self.struct_pat(fields),
            syn::Pat::Reference(reference) => {
                let inner = self.pat(&reference.pat);
                let span = self.span(reference.and_token.span).to(self.pat_span(inner));
                self.add_pat(PatKind::Reference(inner), span)
            }
            syn::Pat::Or(or) => self.alternatives(or),
            syn::Pat::Slice(slice) => {
                let elements = self.pats(&slice.elems);
                let span = self.span(slice.bracket_token.span.join());
                self.add_pat(PatKind::Slice(elements), span)
            }
            syn::Pat::Lit(literal) => {
                let span = self.span(literal.lit.span());
                self.add_pat(PatKind::Literal(literal_text(&literal.lit)), span)
            }
            syn::Pat::Range(range) => self.range_pat(range),
            // The type stands where the pattern is used: in a parameter or `let`.
            syn::Pat::Type(typed) => self.pat(&typed.pat),
            syn::Pat::Const(block) => {
                let text = tokens_text(&block.to_token_stream());
                let span = self.span(block.const_token.span).to(self.span(block.block.brace_token.span.close()));
                self.add_pat(PatKind::Literal(text), span)
            }
            syn::Pat::Verbatim(tokens) => self.verbatim_pat(tokens),
            other => {
                let span = self.span(other.span());
                self.add_pat(PatKind::Unknown, span)
            }
        }
    }

    fn pats<'p>(&mut self, pats: impl IntoIterator<Item = &'p syn::Pat>) -> Vec<PatId> {
        pats.into_iter().map(|pat| self.pat(pat)).collect()
    }

    fn bind(&mut self, ident: &syn::PatIdent) -> PatId {
        let sub = ident.subpat.as_ref().map(|(_, sub)| self.pat(sub));
        let (by_ref, mutable) = (ident.by_ref.is_some(), ident.mutability.is_some());
        let qualifiers = [ident.by_ref.map(|token| token.span), ident.mutability.map(|token| token.span)];
        let own = self.span(ident.ident.span());
        let span = qualifiers.into_iter().flatten().fold(own, |span, token| span.to(self.span(token)));
        let span = sub.map_or(span, |sub| span.to(self.pat_span(sub)));
        self.add_pat(PatKind::Bind { name: name(&ident.ident), by_ref, mutable, sub }, span)
    }

    fn tuple_struct(&mut self, tuple: &syn::PatTupleStruct) -> PatId {
        let elements = self.pats(&tuple.elems);
        let path = self.low.path(tuple.qself.as_ref(), &tuple.path);
        let start = self.low.qualified_span(tuple.qself.as_ref(), &tuple.path);
        let span = start.to(self.span(tuple.paren_token.span.close()));
        self.add_pat(PatKind::TupleStruct(path, elements), span)
    }

    fn struct_pat(&mut self, pat: &syn::PatStruct) -> PatId {
        let mut fields = Vec::new();
        for field in &pat.fields {
            if self.low.cfg_key(&field.attrs).is_some() {
                fields.push((member(&field.member).0, self.pat(&field.pat)));
            }
        }
        let path = self.low.path(pat.qself.as_ref(), &pat.path);
        let start = self.low.qualified_span(pat.qself.as_ref(), &pat.path);
        let span = start.to(self.span(pat.brace_token.span.close()));
        self.add_pat(PatKind::Struct(path, fields), span)
    }

    fn alternatives(&mut self, or: &syn::PatOr) -> PatId {
        let cases = self.pats(&or.cases);
        let spans: Vec<_> = cases.iter().map(|case| self.pat_span(*case)).collect();
        match (cases.as_slice(), spans.as_slice()) {
            ([only], _) => *only,
            (_, [first, .., last]) => self.add_pat(PatKind::Or(cases.clone()), first.to(*last)),
            _ => {
                let span = self.span(or.span());
                self.add_pat(PatKind::Unknown, span)
            }
        }
    }

    fn range_pat(&mut self, range: &syn::PatRange) -> PatId {
        let [start, end] = [&range.start, &range.end].map(|end| end.as_deref().map(|end| self.expr(end)));
        let inclusive = matches!(range.limits, syn::RangeLimits::Closed(_));
        let span = self.span(range.span());
        self.add_pat(PatKind::Range { start, end, inclusive }, span)
    }

    /// `box pat`, or something that is not read.
    fn verbatim_pat(&mut self, tokens: &TokenStream) -> PatId {
        let span = self.low.tokens_span(tokens);
        let mut rest = tokens.clone().into_iter().peekable();
        let mut boxes = 0;
        while matches!(rest.peek(), Some(TokenTree::Ident(word)) if word == "box") {
            rest.next();
            boxes += 1;
        }
        if boxes > 0
            && let Ok(inner) = syn::Pat::parse_single.parse2(rest.collect())
        {
            let inner = self.pat(&inner);
            return (0..boxes).fold(inner, |inner, _| self.add_pat(PatKind::Reference(inner), span));
        }
        self.add_pat(PatKind::Unknown, span)
    }
}

/// A literal in one spelling: integers as decimal numbers without suffix.
fn literal_text(literal: &syn::Lit) -> String {
    match literal {
        syn::Lit::Int(int) => int.base10_digits().to_owned(),
        other => super::literal::literal(other).spelling(),
    }
}
