//! `thread_local!` and `lazy_static!`: statics of the declared type. Never says when they are initialised.

use syn::parse::{Parse, ParseStream};
use syn::{Attribute, Expr, Ident, Token, Type, Visibility};

use super::parse;
use crate::syntax::lower::Lowerer;
use crate::syntax::tree::Item;

struct Statics(Vec<Static>);

/// `pub static ref NAME: Type = value;`
struct Static {
    attributes: Vec<Attribute>,
    vis: Visibility,
    ident: Ident,
    ty: Type,
    value: Expr,
}

impl Parse for Statics {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let mut statics = Vec::new();
        while !input.is_empty() {
            statics.push(input.parse()?);
            if input.is_empty() {
                break;
            }
            input.parse::<Token![;]>()?;
        }
        Ok(Self(statics))
    }
}

impl Parse for Static {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let attributes = input.call(Attribute::parse_outer)?;
        let vis = input.parse()?;
        input.parse::<Token![static]>()?;
        input.parse::<Option<Token![ref]>>()?;
        let ident = input.parse()?;
        input.parse::<Token![:]>()?;
        let ty = input.parse()?;
        input.parse::<Token![=]>()?;
        // `const { … }` is a block expression.
        let value = input.parse()?;
        Ok(Self { attributes, vis, ident, ty, value })
    }
}

impl Lowerer<'_, '_> {
    pub(super) fn macro_statics(&mut self, mac: &syn::Macro, out: &mut Vec<Item>) -> bool {
        let Some(statics) = parse::<Statics>(mac) else { return false };
        for item in &statics.0 {
            self.macro_static((&item.attributes, &item.vis), &item.ident, &item.ty, &item.value, out);
        }
        true
    }
}
