//! `#[derive(Deref, DerefMut)]` of a newtype, as derive_more and Bevy have it: the impls that they write. Whose derive it is does not
//! matter, for all of that name do the same.

use proc_macro2::TokenStream;
use quote::quote_spanned;

use super::Lowerer;
use crate::syntax::tree::{Attribute, Item};

impl Lowerer<'_, '_> {
    /// The impls that a struct derives, from its attributes as they are kept.
    pub(super) fn derived_derefs(&mut self, item: &syn::ItemStruct, kept: &[Attribute]) -> Vec<Item> {
        let derives = |name: &str| kept.iter().any(|attribute| attribute.derives(name));
        let mut derived = Vec::new();
        let code = derives("Deref").then(|| impls(item, derives("DerefMut"))).flatten();
        if let Some(Ok(written)) = code.map(syn::parse2::<syn::File>) {
            self.items(&written.items, &mut derived);
        }
        derived
    }
}

/// The impls; `None` if it is not certain which field is handed out.
fn impls(item: &syn::ItemStruct, is_mutable: bool) -> Option<TokenStream> {
    let (member, ty) = handed_out(item)?;
    let (name, span) = (&item.ident, item.ident.span());
    let (params, args, bounds) = item.generics.split_for_impl();
    let cfgs: Vec<&syn::Attribute> = item.attrs.iter().filter(|own| own.path().is_ident("cfg")).collect();
    let shared = quote_spanned! { span =>
        #(#cfgs)*
        impl #params ::core::ops::Deref for #name #args #bounds {
            type Target = #ty;
            fn deref(&self) -> &Self::Target { &self.#member }
        }
    };
    let exclusive = is_mutable.then(|| {
        quote_spanned! { span =>
            #(#cfgs)*
            impl #params ::core::ops::DerefMut for #name #args #bounds {
                fn deref_mut(&mut self) -> &mut Self::Target { &mut self.#member }
            }
        }
    });
    Some(quote_spanned! { span => #shared #exclusive })
}

/// The field that is handed out: the only one, or the only one that says so. An attribute with arguments asks for something else.
fn handed_out(item: &syn::ItemStruct) -> Option<(syn::Member, &syn::Type)> {
    let attributes = item.fields.iter().flat_map(|field| &field.attrs);
    let says = |attribute: &syn::Attribute, name: &str| attribute.path().is_ident(name);
    let is_other = |attribute: &syn::Attribute| {
        let is_plain = matches!(attribute.meta, syn::Meta::Path(_));
        !is_plain && (says(attribute, "deref") || says(attribute, "deref_mut"))
    };
    if item.attrs.iter().chain(attributes).any(is_other) {
        return None;
    }
    if item.fields.iter().any(|field| field.attrs.iter().any(|own| says(own, "cfg"))) {
        return None;
    }
    let fields: Vec<(syn::Member, &syn::Field)> = item.fields.members().zip(&item.fields).collect();
    let is_named = |(_, field): &&(syn::Member, &syn::Field)| field.attrs.iter().any(|own| says(own, "deref"));
    let named: Vec<_> = fields.iter().filter(is_named).collect();
    let (member, field) = match (fields.as_slice(), named.as_slice()) {
        ([only], _) => only,
        (_, [only]) => *only,
        _ => return None,
    };
    Some((member.clone(), &field.ty))
}
