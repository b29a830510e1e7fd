//! The macros of `ceid-core`: guards, guarded loops, filter sets. Never checks what they check themselves.

use proc_macro2::TokenStream;
use quote::ToTokens as _;
use syn::parse::{Parse, ParseStream};
use syn::{Attribute, Expr, Field, Generics, Ident, Pat, Token, Visibility};

use super::parse;
use crate::syntax::lower::{BodyLowerer, Lowerer, name};
use crate::syntax::text::tokens_text;
use crate::syntax::tree::{ExprId, Item, MacroKind, PatId};

/// `token => a, b = place,`
struct Guard {
    token: Option<Expr>,
    filters: Vec<Expr>,
}

impl Parse for Guard {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let mut token = None;
        let mut filters = Vec::new();
        while !input.is_empty() {
            let expr = input.parse()?;
            if filters.is_empty() && token.is_none() && input.parse::<Option<Token![=>]>>()?.is_some() {
                token = Some(expr);
                continue;
            }
            filters.push(expr);
            if input.is_empty() {
                break;
            }
            input.parse::<Token![,]>()?;
        }
        Ok(Self { token, filters })
    }
}

/// `filters, cycle in control => { body }`
struct EachCycle {
    names: Vec<Pat>,
    control: Expr,
    body: Expr,
}

impl Parse for EachCycle {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let mut names = vec![Pat::parse_single(input)?];
        while input.parse::<Option<Token![,]>>()?.is_some() {
            names.push(Pat::parse_single(input)?);
        }
        input.parse::<Token![in]>()?;
        let control = input.parse()?;
        input.parse::<Token![=>]>()?;
        let body = input.parse()?;
        input.parse::<Option<Token![,]>>()?;
        Ok(Self { names, control, body })
    }
}

/// `pub struct Name @ 1000 Hz { kf: KalmanF; map: Map, every 10 }`, any number of them.
struct FilterSets(Vec<FilterSet>);

struct FilterSet {
    attributes: Vec<Attribute>,
    vis: Visibility,
    keyword: Token![struct],
    ident: Ident,
    generics: Generics,
    brace: syn::token::Brace,
    fields: Vec<Field>,
}

impl Parse for FilterSets {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let mut sets = Vec::new();
        while !input.is_empty() {
            sets.push(input.parse()?);
            input.parse::<Option<Token![;]>>()?;
        }
        Ok(Self(sets))
    }
}

impl Parse for FilterSet {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let attributes = input.call(Attribute::parse_outer)?;
        let vis = input.parse()?;
        let keyword = input.parse()?;
        let ident = input.parse()?;
        let mut generics: Generics = input.parse()?;
        input.parse::<Token![@]>()?;
        // The rate is the library's to check.
        while !input.peek(syn::token::Brace) && !input.peek(Token![where]) && !input.is_empty() {
            input.parse::<proc_macro2::TokenTree>()?;
        }
        generics.where_clause = input.parse()?;
        let content;
        let brace = syn::braced!(content in input);
        let mut fields = Vec::new();
        while !content.is_empty() {
            fields.push(filter_field(&content)?);
        }
        Ok(Self { attributes, vis, keyword, ident, generics, brace, fields })
    }
}

/// `pub kf: KalmanF, every 10;`
fn filter_field(input: ParseStream<'_>) -> syn::Result<Field> {
    let mut field = Field::parse_named(input)?;
    field.attrs.retain(|attribute| !attribute.path().is_ident("doc"));
    let mut separated = input.parse::<Option<Token![;]>>()?.is_some();
    if !separated && input.parse::<Option<Token![,]>>()?.is_some() {
        separated = true;
        let divided = input.peek(Ident) && !input.peek2(Token![:]) && input.fork().parse::<Ident>()? == "every";
        if divided {
            input.parse::<Ident>()?;
            input.parse::<Expr>()?;
            separated = input.is_empty()
                || input.parse::<Option<Token![;]>>()?.is_some()
                || input.parse::<Option<Token![,]>>()?.is_some();
        }
    }
    if separated || input.is_empty() { Ok(field) } else { Err(input.error("expected `;`")) }
}

impl BodyLowerer<'_, '_, '_> {
    pub(super) fn ceid(&mut self, mac: &syn::Macro) -> Option<MacroKind> {
        let guard = parse::<Guard>(mac)?;
        let token = guard.token.as_ref().map(|token| self.expr(token));
        let filters: Vec<(String, ExprId)> = guard.filters.iter().map(|filter| self.guarded(filter)).collect();
        let named = guard.filters.iter().zip(&filters).filter_map(|(filter, (_, place))| match filter {
            Expr::Assign(assign) => Some((&*assign.left, *place)),
            _ => None,
        });
        let names = named.filter_map(|(name, place)| Some((self.guarded_name(name)?, place))).collect();
        Some(MacroKind::Ceid { token, filters, names })
    }

    /// `kf` in `kf = self.kf`, which is a variable from there on.
    fn guarded_name(&mut self, name: &Expr) -> Option<PatId> {
        let Expr::Path(path) = name else { return None };
        let ident = path.path.get_ident()?.clone();
        let pat = syn::PatIdent { attrs: Vec::new(), by_ref: None, mutability: None, ident, subpat: None };
        Some(self.pat(&Pat::Ident(pat)))
    }

    /// `name = place`, or a place that is its own name.
    fn guarded(&mut self, filter: &Expr) -> (String, ExprId) {
        match filter {
            Expr::Assign(assign) => (place_name(&assign.left), self.expr(&assign.right)),
            place => (place_name(place), self.expr(place)),
        }
    }

    pub(super) fn each_cycle(&mut self, mac: &syn::Macro) -> Option<MacroKind> {
        let parsed = parse::<EachCycle>(mac)?;
        let control = self.expr(&parsed.control);
        let names = parsed.names.iter().map(|name| self.pat(name)).collect();
        let body = self.expr(&parsed.body);
        Some(MacroKind::EachCycle { names, control, body })
    }
}

fn place_name(place: &Expr) -> String {
    match place {
        Expr::Path(path) => path.path.get_ident().map_or_else(|| text(place), name),
        other => text(other),
    }
}

fn text(expr: &Expr) -> String {
    let tokens: TokenStream = expr.to_token_stream();
    tokens_text(&tokens)
}

impl Lowerer<'_, '_> {
    /// Adds the structs of `filters!`, marked with the attribute `ceid_core::filters`.
    pub(super) fn filter_sets(&mut self, mac: &syn::Macro, out: &mut Vec<Item>) -> bool {
        let Some(sets) = parse::<FilterSets>(mac) else { return false };
        let call = self.opaque(mac).span;
        for set in &sets.0 {
            let fields = self.field_list(&set.fields);
            let generics = self.generics(&set.generics);
            let places = (set.keyword.span, set.brace.span.close());
            let before = out.len();
            self.macro_struct((&set.attributes, &set.vis), (&set.ident, generics), places, fields, out);
            for item in &mut out[before..] {
                let path = "ceid_core::filters".to_owned();
                item.attributes.push(crate::syntax::tree::Attribute { path, arguments: String::new(), span: call });
            }
        }
        true
    }
}
