//! Items. Never resolves a name; a known macro becomes the items it stands for.

use super::attrs::Attrs;
use super::{Lowerer, name};
use crate::source::Span;
use crate::syntax::tree::{CfgKey, Field, Fields, Generics, Item, ItemKind, ValueItem, Variant};

impl Lowerer<'_, '_> {
    pub(in crate::syntax) fn items(&mut self, items: &[syn::Item], out: &mut Vec<Item>) {
        for item in items {
            self.item(item, out);
        }
        // Of two items of one name, the one that a release build has is judged.
        let kept: Vec<String> = out.iter().filter(|item| !is_debug_only(item)).map(|item| item.name.clone()).collect();
        out.retain(|item| !is_debug_only(item) || item.name.is_empty() || !kept.contains(&item.name));
    }

    pub(in crate::syntax) fn item(&mut self, item: &syn::Item, out: &mut Vec<Item>) {
        if self.is_silent_item(item) {
            return;
        }
        let before = out.len();
        if !self.duplicate_items(item, out) {
            self.present_item(item, out);
        }
        if out.len() == before {
            self.note_removed(item);
        }
    }

    /// Keeps the names of an item that is not there under this `cfg`.
    pub(in crate::syntax) fn note_removed(&mut self, item: &syn::Item) {
        let ident = match item {
            syn::Item::Fn(item) => &item.sig.ident,
            syn::Item::Struct(item) => &item.ident,
            syn::Item::Enum(item) => &item.ident,
            syn::Item::Trait(item) => &item.ident,
            syn::Item::Type(item) => &item.ident,
            syn::Item::Mod(item) => {
                let attrs = self.attrs(&item.attrs);
                self.loader.leave_out(&name(&item.ident), attrs.paths(), &self.dir);
                &item.ident
            }
            syn::Item::Use(item) => {
                let names = self.use_names(item).into_iter().filter_map(|own| own.name);
                self.loader.removed.extend(names);
                return;
            }
            syn::Item::Impl(item) => {
                for own in &item.items {
                    if let syn::ImplItem::Fn(own) = own {
                        self.loader.removed.insert(name(&own.sig.ident));
                    }
                }
                return;
            }
            _ => return,
        };
        self.loader.removed.insert(name(ident));
    }

    fn present_item(&mut self, item: &syn::Item, out: &mut Vec<Item>) {
        match item {
            syn::Item::Fn(item) => self.fn_item(item, out),
            syn::Item::Struct(item) => self.struct_item(item, out),
            syn::Item::Union(item) => self.union_item(item, out),
            syn::Item::Enum(item) => self.enum_item(item, out),
            syn::Item::Impl(item) => self.impl_item_block(item, out),
            syn::Item::Trait(item) => self.trait_item_block(item, out),
            syn::Item::TraitAlias(item) => self.trait_alias(item, out),
            syn::Item::Type(item) => self.type_alias(item, out),
            syn::Item::Const(item) => self.const_item(item, out),
            syn::Item::Static(item) => self.static_item(item, out),
            syn::Item::Mod(item) => self.mod_item(item, out),
            syn::Item::Use(item) => self.use_item(item, out),
            syn::Item::ExternCrate(item) => self.extern_crate(item, out),
            syn::Item::ForeignMod(item) => self.foreign_mod(item, out),
            syn::Item::Macro(item) => self.item_macro(item, out),
            syn::Item::Verbatim(tokens) => {
                let mac = self.verbatim(tokens);
                let (span, attrs) = (mac.span, self.attrs(&[]));
                self.push(out, Head { ident: None, attrs, is_pub: false, span }, ItemKind::MacroCall(mac));
            }
            _ => {}
        }
    }

    /// The head of an item, or `None` if `cfg` removed it.
    fn head_of<'i>(
        &self,
        attributes: &[syn::Attribute],
        vis: Option<&syn::Visibility>,
        ident: Option<&'i syn::Ident>,
        keyword: Span,
        end: Span,
    ) -> Option<Head<'i>> {
        let attrs = self.there(attributes)?;
        let start = match vis {
            Some(syn::Visibility::Public(token)) => self.span(token.span),
            Some(syn::Visibility::Restricted(restricted)) => self.span(restricted.pub_token.span),
            _ => keyword,
        };
        Some(Head { ident, attrs, is_pub: vis.is_some_and(is_pub), span: start.to(keyword).to(end) })
    }

    fn push(&self, out: &mut Vec<Item>, head: Head<'_>, kind: ItemKind) {
        let Some(cfg) = head.attrs.presence.and(self.given.clone()).key() else { return };
        // A filter that only a debug build has is none.
        if matches!(&kind, ItemKind::Value(value) if value.is_static) && cfg.as_ref().is_some_and(CfgKey::is_debug_only)
        {
            return;
        }
        let (name, name_span) = match head.ident {
            Some(ident) => self.name_and_span(ident),
            None => (String::new(), head.span),
        };
        out.push(Item {
            name,
            name_span,
            span: head.span,
            attributes: head.attrs.kept,
            cfg,
            is_pub: head.is_pub,
            kind,
        });
    }

    fn fn_item(&mut self, item: &syn::ItemFn, out: &mut Vec<Item>) {
        let start = self.head_start(&item.sig);
        let end = self.span(item.block.brace_token.span.close());
        if let Some(head) = self.head_of(&item.attrs, Some(&item.vis), Some(&item.sig.ident), start, end) {
            let function = self.function_with(&item.attrs, &item.sig, Some(&item.block));
            self.push(out, head, ItemKind::Function(Box::new(function)));
        }
    }

    fn struct_item(&mut self, item: &syn::ItemStruct, out: &mut Vec<Item>) {
        let start = self.span(item.struct_token.span);
        let end = match (&item.semi_token, &item.fields) {
            (Some(semi), _) => self.span(semi.span),
            (None, syn::Fields::Named(fields)) => self.span(fields.brace_token.span.close()),
            (None, _) => self.span(item.ident.span()),
        };
        if let Some(head) = self.head_of(&item.attrs, Some(&item.vis), Some(&item.ident), start, end) {
            let (generics, fields) = (self.generics(&item.generics), self.fields(&item.fields));
            let derived = self.derived_derefs(item, &head.attrs.kept);
            self.push(out, head, ItemKind::Struct { generics, fields });
            out.extend(derived);
        }
    }

    fn union_item(&mut self, item: &syn::ItemUnion, out: &mut Vec<Item>) {
        let start = self.span(item.union_token.span);
        let end = self.span(item.fields.brace_token.span.close());
        if let Some(head) = self.head_of(&item.attrs, Some(&item.vis), Some(&item.ident), start, end) {
            let fields = Fields { named: true, fields: self.field_list(&item.fields.named) };
            self.push(out, head, ItemKind::Struct { generics: self.generics(&item.generics), fields });
        }
    }

    fn enum_item(&mut self, item: &syn::ItemEnum, out: &mut Vec<Item>) {
        let start = self.span(item.enum_token.span);
        let end = self.span(item.brace_token.span.close());
        let Some(head) = self.head_of(&item.attrs, Some(&item.vis), Some(&item.ident), start, end) else { return };
        let present = item.variants.iter().filter(|variant| self.is_part(&variant.attrs));
        let variants = present
            .map(|variant| Variant {
                name: name(&variant.ident),
                fields: self.fields(&variant.fields),
                number: variant.discriminant.as_ref().map(|(_, value)| match value {
                    syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Int(int), .. }) => int.base10_parse().ok(),
                    _ => None,
                }),
            })
            .collect();
        self.push(out, head, ItemKind::Enum { generics: self.generics(&item.generics), variants });
    }

    fn fields(&self, fields: &syn::Fields) -> Fields {
        match fields {
            syn::Fields::Unit => Fields::default(),
            syn::Fields::Named(fields) => Fields { named: true, fields: self.field_list(&fields.named) },
            syn::Fields::Unnamed(fields) => Fields { named: false, fields: self.field_list(&fields.unnamed) },
        }
    }

    pub(in crate::syntax) fn field_list<'f>(&self, fields: impl IntoIterator<Item = &'f syn::Field>) -> Vec<Field> {
        let present = fields.into_iter().filter(|field| self.is_part(&field.attrs));
        let lowered = present.enumerate().map(|(index, field)| Field {
            name: field.ident.as_ref().map_or_else(|| index.to_string(), name),
            span: field.ident.as_ref().map_or_else(|| self.type_span(&field.ty), |ident| self.span(ident.span())),
            ty: self.ty(&field.ty),
        });
        lowered.collect()
    }

    fn impl_item_block(&mut self, item: &syn::ItemImpl, out: &mut Vec<Item>) {
        // `impl !Trait for Type` says what is not there.
        if item.modifiers.polarity.is_some() {
            return;
        }
        let start = first_span(
            [item.modifiers.defaultness.map(|token| token.span), item.unsafety.map(|token| token.span)],
            item.impl_token.span,
        );
        let (start, end) = (self.span(start), self.span(item.brace_token.span.close()));
        if let Some(mut head) = self.head_of(&item.attrs, None, None, start, end) {
            head.span = start.to(end);
            let kind = ItemKind::Impl {
                generics: self.generics(&item.generics),
                trait_path: item.trait_.as_ref().map(|(path, _)| self.path(None, path)),
                self_ty: self.ty(&item.self_ty),
                items: self.impl_items(&item.items),
            };
            self.push(out, head, kind);
        }
    }

    fn trait_item_block(&mut self, item: &syn::ItemTrait, out: &mut Vec<Item>) {
        let start = first_span(
            [item.unsafety.map(|token| token.span), item.modifiers.auto_token.map(|token| token.span)],
            item.trait_token.span,
        );
        let (start, end) = (self.span(start), self.span(item.brace_token.span.close()));
        if let Some(head) = self.head_of(&item.attrs, Some(&item.vis), Some(&item.ident), start, end) {
            let kind = ItemKind::Trait {
                generics: self.generics(&item.generics),
                supertraits: self.bounds(&item.supertraits),
                items: self.trait_items(&item.items),
            };
            self.push(out, head, kind);
        }
    }

    fn trait_alias(&self, item: &syn::ItemTraitAlias, out: &mut Vec<Item>) {
        let (start, end) = (self.span(item.trait_token.span), self.span(item.semi_token.span));
        if let Some(head) = self.head_of(&item.attrs, Some(&item.vis), Some(&item.ident), start, end) {
            let supertraits = self.bounds(&item.bounds);
            let kind = ItemKind::Trait { generics: self.generics(&item.generics), supertraits, items: Vec::new() };
            self.push(out, head, kind);
        }
    }

    fn type_alias(&self, item: &syn::ItemType, out: &mut Vec<Item>) {
        let (start, end) = (self.span(item.type_token.span), self.span(item.semi_token.span));
        if let Some(head) = self.head_of(&item.attrs, Some(&item.vis), Some(&item.ident), start, end) {
            let (generics, ty) = (self.generics(&item.generics), self.ty(&item.ty));
            self.push(out, head, ItemKind::TypeAlias { generics, ty });
        }
    }

    fn const_item(&mut self, item: &syn::ItemConst, out: &mut Vec<Item>) {
        let (start, end) = (self.span(item.const_token.span), self.span(item.semi_token.span));
        if let Some(head) = self.head_of(&item.attrs, Some(&item.vis), Some(&item.ident), start, end) {
            let ty = self.ty(&item.ty);
            let value = Some(self.value_body(&item.expr));
            self.push(
                out,
                head,
                ItemKind::Value(Box::new(ValueItem { is_static: false, is_mutable: false, ty, value })),
            );
        }
    }

    fn static_item(&mut self, item: &syn::ItemStatic, out: &mut Vec<Item>) {
        let (start, end) = (self.span(item.static_token.span), self.span(item.semi_token.span));
        if let Some(head) = self.head_of(&item.attrs, Some(&item.vis), Some(&item.ident), start, end) {
            let is_mutable = matches!(item.mutability, syn::StaticMutability::Mut(_));
            self.push_static(out, head, &item.ty, Some(&item.expr), is_mutable);
        }
    }

    fn push_static(
        &mut self,
        out: &mut Vec<Item>,
        head: Head<'_>,
        ty: &syn::Type,
        value: Option<&syn::Expr>,
        is_mutable: bool,
    ) {
        let ty = self.ty(ty);
        let value = value.map(|value| self.value_body(value));
        self.push(out, head, ItemKind::Value(Box::new(ValueItem { is_static: true, is_mutable, ty, value })));
    }

    /// A static that a macro declares.
    pub(in crate::syntax) fn macro_static(
        &mut self,
        (attributes, vis): (&[syn::Attribute], &syn::Visibility),
        ident: &syn::Ident,
        ty: &syn::Type,
        value: &syn::Expr,
        out: &mut Vec<Item>,
    ) {
        let start = self.span(ident.span());
        let end = self.type_span(ty);
        if let Some(head) = self.head_of(attributes, Some(vis), Some(ident), start, end) {
            self.push_static(out, head, ty, Some(value), false);
        }
    }

    /// A struct that a macro declares.
    pub(in crate::syntax) fn macro_struct(
        &self,
        (attributes, vis): (&[syn::Attribute], &syn::Visibility),
        (ident, generics): (&syn::Ident, Generics),
        (keyword, end): (proc_macro2::Span, proc_macro2::Span),
        fields: Vec<Field>,
        out: &mut Vec<Item>,
    ) {
        let (start, end) = (self.span(keyword), self.span(end));
        if let Some(head) = self.head_of(attributes, Some(vis), Some(ident), start, end) {
            self.push(out, head, ItemKind::Struct { generics, fields: Fields { named: true, fields } });
        }
    }

    fn mod_item(&mut self, item: &syn::ItemMod, out: &mut Vec<Item>) {
        let keyword = self.span(item.mod_token.span);
        let end = match (&item.content, &item.semi) {
            (Some((brace, _)), _) => self.span(brace.span.close()),
            (None, Some(semi)) => self.span(semi.span),
            (None, None) => self.span(item.ident.span()),
        };
        let Some(mut head) = self.head_of(&item.attrs, Some(&item.vis), Some(&item.ident), keyword, end) else {
            return;
        };
        let module = name(&item.ident);
        let mut items = Vec::new();
        let mark = self.loader.own.mark();
        if let Some((_, content)) = &item.content {
            // An inline module's `#[path]` names a directory.
            let dir = self.dir.inline(&module, head.attrs.module_path(|_| true));
            self.within(dir, |low| low.items(content, &mut items));
        } else {
            let place = self.span(item.ident.span());
            if let Some(file) = self.loader.module(&module, place, &head.attrs, &self.dir) {
                // `#![cfg]` in a file decides whether the module is there at all.
                head.attrs.presence = head.attrs.presence.and(file.attrs.presence);
                head.attrs.kept.extend(file.attrs.kept);
                items = file.items;
            }
        }
        if !head.attrs.has("macro_use") {
            self.loader.own.leave(&mark);
        }
        self.push(out, head, ItemKind::Mod(items));
    }

    fn use_item(&self, item: &syn::ItemUse, out: &mut Vec<Item>) {
        let (start, end) = (self.span(item.use_token.span), self.span(item.semi_token.span));
        if let Some(head) = self.head_of(&item.attrs, Some(&item.vis), None, start, end) {
            self.push(out, head, ItemKind::Use(self.use_names(item)));
        }
    }

    fn extern_crate(&self, item: &syn::ItemExternCrate, out: &mut Vec<Item>) {
        let (start, end) = (self.span(item.extern_token.span), self.span(item.semi_token.span));
        if let Some(head) = self.head_of(&item.attrs, Some(&item.vis), Some(&item.ident), start, end) {
            let alias = item.rename.as_ref().map(|(_, alias)| name(alias));
            self.push(out, head, ItemKind::ExternCrate { alias });
        }
    }

    /// The functions, statics and types of an `extern` block, as signatures.
    fn foreign_mod(&mut self, item: &syn::ItemForeignMod, out: &mut Vec<Item>) {
        let Some(block) = self.there(&item.attrs) else { return };
        self.given(block.presence, |low| {
            for foreign in &item.items {
                low.foreign_item(foreign, out);
            }
        });
    }

    fn foreign_item(&mut self, item: &syn::ForeignItem, out: &mut Vec<Item>) {
        match item {
            syn::ForeignItem::Fn(item) => {
                let (start, end) = (self.head_start(&item.sig), self.span(item.semi_token.span));
                if let Some(head) = self.head_of(&item.attrs, Some(&item.vis), Some(&item.sig.ident), start, end) {
                    let function = self.function_with(&item.attrs, &item.sig, None);
                    self.push(out, head, ItemKind::Function(Box::new(function)));
                }
            }
            syn::ForeignItem::Static(item) => {
                let (start, end) = (self.span(item.static_token.span), self.span(item.semi_token.span));
                if let Some(head) = self.head_of(&item.attrs, Some(&item.vis), Some(&item.ident), start, end) {
                    self.push_static(out, head, &item.ty, None, true);
                }
            }
            syn::ForeignItem::Type(item) => {
                let (start, end) = (self.span(item.type_token.span), self.span(item.semi_token.span));
                if let Some(head) = self.head_of(&item.attrs, Some(&item.vis), Some(&item.ident), start, end) {
                    let generics = self.generics(&item.generics);
                    self.push(out, head, ItemKind::Struct { generics, fields: Fields::default() });
                }
            }
            syn::ForeignItem::Macro(item) => {
                let mac = self.opaque(&item.mac);
                if let Some(head) = self.head_of(&item.attrs, None, None, mac.span, mac.span) {
                    self.push(out, head, ItemKind::MacroCall(mac));
                }
            }
            syn::ForeignItem::Verbatim(tokens) => {
                let mac = self.verbatim(tokens);
                let head = Head { ident: None, attrs: self.attrs(&[]), is_pub: false, span: mac.span };
                self.push(out, head, ItemKind::MacroCall(mac));
            }
            _ => {}
        }
    }

    fn item_macro(&mut self, item: &syn::ItemMacro, out: &mut Vec<Item>) {
        let mac = self.opaque(&item.mac);
        let end = item.semi_token.map_or(mac.span, |semi| self.span(semi.span));
        let Some(head) = self.head_of(&item.attrs, None, item.ident.as_ref(), mac.span, end) else { return };
        if item.ident.is_some() && mac.path == "macro_rules" {
            let exported = head.attrs.has("macro_export");
            if let Some(ident) = &item.ident {
                let presence = head.attrs.presence.clone().and(self.given.clone());
                self.define_macro(ident, &item.mac.tokens, &presence);
            }
            self.push(out, head, ItemKind::MacroRules { rules: mac.tokens, exported });
            return;
        }
        let is_read = |low: &mut Self| low.known_item_macro(&item.mac, out) || low.own_items(&item.mac, out);
        if !self.given(head.attrs.presence.clone(), is_read) {
            self.loader.leave_out_declared(&item.mac.tokens, &self.dir);
            self.push(out, head, ItemKind::MacroCall(mac));
        }
    }
}

/// What all kinds of items have.
struct Head<'i> {
    ident: Option<&'i syn::Ident>,
    attrs: Attrs,
    is_pub: bool,
    span: Span,
}

fn is_debug_only(item: &Item) -> bool {
    item.cfg.as_ref().is_some_and(CfgKey::is_debug_only)
}

pub(super) fn is_pub(vis: &syn::Visibility) -> bool {
    !matches!(vis, syn::Visibility::Inherited)
}

fn first_span(qualifiers: [Option<proc_macro2::Span>; 2], keyword: proc_macro2::Span) -> proc_macro2::Span {
    qualifiers.into_iter().flatten().next().unwrap_or(keyword)
}
