//! Attributes: what `cfg` says, where `#[path]` points, and the rest as text. Never keeps docs.

use proc_macro2::TokenStream;
use quote::ToTokens as _;
use syn::parse::{ParseStream, Parser as _};

use super::{Lowerer, path_text};
use crate::source::Span;
use crate::syntax::cfg_eval::{Presence, evaluate, predicate};
use crate::syntax::text::tokens_text;
use crate::syntax::tree::{Attribute, CfgKey};

/// What the attributes of something say.
#[derive(Clone, Debug)]
pub(in crate::syntax) struct Attrs {
    /// All but docs, `cfg` and `cfg_attr`.
    pub(in crate::syntax) kept: Vec<Attribute>,
    /// Whether the thing is there.
    pub(in crate::syntax) presence: Presence,
    /// The `#[path]`s that may hold, with whether it is certain.
    paths: Vec<(String, bool)>,
    /// Whether a `cfg_attr` that does not hold has one.
    pub(in crate::syntax) leaves_out_path: bool,
}

impl Attrs {
    /// The key if the thing may be there; `None` if it is not.
    pub(super) fn key(&self) -> Option<Option<CfgKey>> {
        self.presence.clone().key()
    }

    /// The `#[path]` of a module: the first certain one, else the first uncertain one whose file is there.
    pub(in crate::syntax) fn module_path(&self, exists: impl Fn(&str) -> bool) -> Option<&str> {
        let certain = self.paths.iter().find(|(_, certain)| *certain);
        let found = certain.or_else(|| self.paths.iter().find(|(path, _)| exists(path)));
        found.map(|(path, _)| path.as_str())
    }

    /// All the `#[path]`s that may hold.
    pub(super) fn paths(&self) -> impl Iterator<Item = &str> {
        self.paths.iter().map(|(path, _)| path.as_str())
    }

    pub(super) fn has(&self, path: &str) -> bool {
        self.kept.iter().any(|attribute| attribute.path == path)
    }
}

impl Lowerer<'_, '_> {
    pub(in crate::syntax) fn attrs(&self, attributes: &[syn::Attribute]) -> Attrs {
        let mut attrs =
            Attrs { kept: Vec::new(), presence: Presence::Present, paths: Vec::new(), leaves_out_path: false };
        // Most attributes are docs.
        for attribute in attributes.iter().filter(|attribute| !attribute.path().is_ident("doc")) {
            let span = self.span(attribute.pound_token.span).to(self.span(attribute.bracket_token.span.close()));
            self.meta(&attribute.meta, span, &Presence::Present, &mut attrs);
        }
        attrs
    }

    /// Whether a field, variant or parameter with these attributes may be there in a release build.
    pub(super) fn is_part(&self, attributes: &[syn::Attribute]) -> bool {
        self.cfg_key(attributes).is_some_and(|key| key.is_none_or(|key| !key.is_debug_only()))
    }

    /// Whether something with these attributes is there: `None` if not.
    pub(super) fn cfg_key(&self, attributes: &[syn::Attribute]) -> Option<Option<CfgKey>> {
        // Most things have no attributes at all.
        if attributes.is_empty() { Some(None) } else { self.attrs(attributes).key() }
    }

    fn meta(&self, meta: &syn::Meta, span: Span, given: &Presence, attrs: &mut Attrs) {
        let path = path_text(meta.path());
        match (path.as_str(), meta) {
            ("doc", _) => {}
            ("cfg", syn::Meta::List(list)) => {
                // `cfg_attr(p, cfg(q))` removes the thing if p holds and q does not.
                let value = evaluate(&list.tokens, self.cfg());
                let removed = given.clone().and(value.not());
                attrs.presence = attrs.presence.clone().and(removed.not());
            }
            ("cfg_attr", syn::Meta::List(list)) => self.cfg_attr(&list.tokens, span, given, attrs),
            _ => {
                let certain = *given == Presence::Present;
                if path == "path"
                    && let Some(value) = string_value(meta)
                {
                    attrs.paths.push((value, certain));
                }
                if certain {
                    let arguments = self.meta_arguments(meta);
                    attrs.kept.push(Attribute { path, arguments, span });
                }
            }
        }
    }

    fn cfg_attr(&self, tokens: &TokenStream, span: Span, given: &Presence, attrs: &mut Attrs) {
        let parsed = (|input: ParseStream<'_>| {
            let value = predicate(input, self.cfg())?;
            let mut metas = Vec::new();
            while input.parse::<Option<syn::Token![,]>>()?.is_some() && !input.is_empty() {
                metas.push(input.parse::<syn::Meta>()?);
            }
            Ok((value, metas))
        })
        .parse2(tokens.clone());
        let Ok((value, metas)) = parsed else { return };
        let given = given.clone().and(value);
        if given == Presence::Absent {
            attrs.leaves_out_path |= metas.iter().any(|meta| meta.path().is_ident("path"));
            return;
        }
        for meta in &metas {
            self.meta(meta, span, &given, attrs);
        }
    }

    /// What follows the path, in the source's spelling.
    fn meta_arguments(&self, meta: &syn::Meta) -> String {
        // The tokens of a macro's code do not stand in the source as they are.
        if self.progress.is_inside() {
            let tokens = tokens_text(&meta.to_token_stream());
            return tokens.strip_prefix(&path_text(meta.path())).unwrap_or_default().to_owned();
        }
        match meta {
            syn::Meta::Path(_) => String::new(),
            syn::Meta::List(list) => self.snippet(self.span(list.delimiter.span().join())).to_owned(),
            syn::Meta::NameValue(pair) => {
                let value = syn::spanned::Spanned::span(&pair.value);
                self.snippet(self.span(pair.eq_token.span).to(self.span(value))).to_owned()
            }
        }
    }
}

fn string_value(meta: &syn::Meta) -> Option<String> {
    match meta {
        syn::Meta::NameValue(syn::MetaNameValue {
            value: syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(text), .. }),
            ..
        }) => Some(text.value()),
        _ => None,
    }
}
