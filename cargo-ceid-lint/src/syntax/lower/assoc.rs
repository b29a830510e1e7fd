//! The items of traits and impls. Never looks for what a trait gives by default.

use super::attrs::Attrs;
use super::items::is_pub;
use super::{Lowerer, name};
use crate::source::Span;
use crate::syntax::text::{fields, mentions};
use crate::syntax::tree::{AssocItem, AssocKind, CfgKey, OpaqueMacro, ValueItem};

impl Lowerer<'_, '_> {
    pub(in crate::syntax) fn trait_items(&mut self, items: &[syn::TraitItem]) -> Vec<AssocItem> {
        let mut lowered = Vec::new();
        for item in items {
            if let syn::TraitItem::Macro(call) = item
                && let Some(own) = self.own_assoc_items(&call.attrs, |low| low.own_trait_items(&call.mac))
            {
                lowered.extend(own);
            } else {
                let present = self.trait_item(item);
                if let (None, syn::TraitItem::Fn(item)) = (&present, item) {
                    self.loader.removed.insert(name(&item.sig.ident));
                }
                lowered.extend(present);
            }
        }
        lowered
    }

    pub(in crate::syntax) fn impl_items(&mut self, items: &[syn::ImplItem]) -> Vec<AssocItem> {
        let mut lowered = Vec::new();
        for item in items {
            if let syn::ImplItem::Macro(call) = item
                && let Some(own) = self.own_assoc_items(&call.attrs, |low| low.own_impl_items(&call.mac))
            {
                lowered.extend(own);
            } else if let Some(own) = self.duplicate_impl_items(item) {
                lowered.extend(own);
            } else {
                let present = self.impl_item(item);
                if let (None, syn::ImplItem::Fn(item)) = (&present, item) {
                    self.loader.removed.insert(name(&item.sig.ident));
                }
                lowered.extend(present);
            }
        }
        let is_debug_only = |item: &AssocItem| item.cfg.as_ref().is_some_and(CfgKey::is_debug_only);
        let kept: Vec<String> =
            lowered.iter().filter(|item| !is_debug_only(item)).map(|item| item.name.clone()).collect();
        lowered.retain(|item| !is_debug_only(item) || !kept.contains(&item.name));
        lowered
    }

    /// The items that a call of one of the crate's own macros stands for, if it is certain that the call is there.
    fn own_assoc_items(
        &mut self,
        attributes: &[syn::Attribute],
        items: impl FnOnce(&mut Self) -> Option<Vec<AssocItem>>,
    ) -> Option<Vec<AssocItem>> {
        if matches!(self.cfg_key(attributes), Some(None)) { items(self) } else { None }
    }

    /// `None` if `cfg` removed it.
    fn trait_item(&mut self, item: &syn::TraitItem) -> Option<AssocItem> {
        match item {
            syn::TraitItem::Fn(item) => {
                let attrs = self.there(&item.attrs)?;
                let function = self.function_with(&item.attrs, &item.sig, item.default.as_ref());
                self.assoc(Some(&item.sig.ident), attrs, true, AssocKind::Function(Box::new(function)))
            }
            syn::TraitItem::Const(item) => {
                let attrs = self.there(&item.attrs)?;
                let ty = self.ty(&item.ty);
                let value = item.default.as_ref().map(|(_, value)| self.value_body(value));
                let kind = AssocKind::Const(Box::new(ValueItem { is_static: false, is_mutable: false, ty, value }));
                self.assoc(Some(&item.ident), attrs, true, kind)
            }
            syn::TraitItem::Type(item) => {
                let attrs = self.there(&item.attrs)?;
                let bounds = self.bounds(&item.bounds);
                let ty = item.default.as_ref().map(|(_, ty)| self.ty(ty));
                self.assoc(Some(&item.ident), attrs, true, AssocKind::Type { bounds, ty })
            }
            syn::TraitItem::Macro(item) => {
                let attrs = self.there(&item.attrs)?;
                let mac = self.opaque(&item.mac);
                self.assoc(None, attrs, true, AssocKind::MacroCall(mac))
            }
            syn::TraitItem::Verbatim(tokens) => self.assoc_verbatim(tokens),
            _ => None,
        }
    }

    fn impl_item(&mut self, item: &syn::ImplItem) -> Option<AssocItem> {
        match item {
            syn::ImplItem::Fn(item) => {
                let attrs = self.there(&item.attrs)?;
                let function = self.function_with(&item.attrs, &item.sig, Some(&item.block));
                self.assoc(Some(&item.sig.ident), attrs, is_pub(&item.vis), AssocKind::Function(Box::new(function)))
            }
            syn::ImplItem::Const(item) => {
                let attrs = self.there(&item.attrs)?;
                let ty = self.ty(&item.ty);
                let value = Some(self.value_body(&item.expr));
                let kind = AssocKind::Const(Box::new(ValueItem { is_static: false, is_mutable: false, ty, value }));
                self.assoc(Some(&item.ident), attrs, is_pub(&item.vis), kind)
            }
            syn::ImplItem::Type(item) => {
                let attrs = self.there(&item.attrs)?;
                let ty = Some(self.ty(&item.ty));
                self.assoc(Some(&item.ident), attrs, is_pub(&item.vis), AssocKind::Type { bounds: Vec::new(), ty })
            }
            syn::ImplItem::Macro(item) => {
                let attrs = self.there(&item.attrs)?;
                let mac = self.opaque(&item.mac);
                self.assoc(None, attrs, false, AssocKind::MacroCall(mac))
            }
            syn::ImplItem::Verbatim(tokens) => self.assoc_verbatim(tokens),
            _ => None,
        }
    }

    /// The attributes, if the thing may be there.
    pub(super) fn there(&self, attributes: &[syn::Attribute]) -> Option<Attrs> {
        Some(self.attrs(attributes)).filter(Attrs::is_there)
    }

    fn assoc(&self, ident: Option<&syn::Ident>, attrs: Attrs, is_pub: bool, kind: AssocKind) -> Option<AssocItem> {
        let cfg = attrs.key()?;
        let name_span = match (&kind, ident) {
            (_, Some(ident)) => self.span(ident.span()),
            (AssocKind::MacroCall(mac), None) => mac.span,
            (AssocKind::Function(function), None) => function.head,
            (AssocKind::Type { .. } | AssocKind::Const(_), None) => Span::new(self.file, 0, 0),
        };
        let name = ident.map(name).unwrap_or_default();
        Some(AssocItem { name, name_span, attributes: attrs.kept, cfg, is_pub, kind })
    }

    /// Syntax that the parser keeps as tokens is treated as a macro without a name.
    fn assoc_verbatim(&self, tokens: &proc_macro2::TokenStream) -> Option<AssocItem> {
        let mac = self.verbatim(tokens);
        self.assoc(None, self.attrs(&[]), false, AssocKind::MacroCall(mac))
    }

    /// Syntax that the parser keeps as tokens.
    pub(super) fn verbatim(&self, tokens: &proc_macro2::TokenStream) -> OpaqueMacro {
        let span = self.tokens_span(tokens);
        OpaqueMacro {
            path: String::new(),
            span,
            tokens: span,
            mentions: mentions(tokens),
            fields: fields(tokens),
            ways_out: Vec::new(),
        }
    }

    pub(super) fn tokens_span(&self, tokens: &proc_macro2::TokenStream) -> Span {
        let mut spans = tokens.clone().into_iter().map(|token| self.span(token.span()));
        let first = spans.next().unwrap_or(Span::new(self.file, 0, 0));
        spans.last().map_or(first, |last| first.to(last))
    }
}
