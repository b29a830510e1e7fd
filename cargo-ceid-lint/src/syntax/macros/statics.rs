//! `thread_local!` and `lazy_static!`: statics of the declared type. Never says when they are initialised.

use syn::parse::{Parse, ParseStream};
use syn::{Attribute, Expr, Ident, Token, Type, Visibility};

use super::parse;
use crate::syntax::lower::Lowerer;
use crate::syntax::tree::{GenericArg, Item, ItemKind, Path, TypeRef};

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
    /// Adds the statics of a macro; those of one thread are reached through a key.
    pub(super) fn macro_statics(&mut self, mac: &syn::Macro, is_local: bool, out: &mut Vec<Item>) -> bool {
        let Some(statics) = parse::<Statics>(mac) else { return false };
        for item in &statics.0 {
            let before = out.len();
            self.macro_static((&item.attributes, &item.vis), &item.ident, &item.ty, &item.value, out);
            for item in out[before..].iter_mut().filter(|_| is_local) {
                if let ItemKind::Value(value) = &mut item.kind {
                    value.ty = local_key(std::mem::replace(&mut value.ty, TypeRef::Infer));
                }
            }
        }
        true
    }
}

/// `std::thread::LocalKey<T>`
fn local_key(ty: TypeRef) -> TypeRef {
    let mut path = Path::plain(&["std", "thread", "LocalKey"]);
    if let Some(last) = path.segments.last_mut() {
        last.args.push(GenericArg::Type(ty));
    }
    TypeRef::Path(path)
}
