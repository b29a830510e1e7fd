//! The operands of formatting, logging and the like.

use syn::ext::IdentExt as _;
use syn::parse::{Parse, ParseStream};
use syn::{Expr, Ident, Pat, Token};

/// `a, b, name = c,`
pub(super) struct Operands {
    pub(super) values: Vec<Expr>,
    /// The names that some of them are given.
    pub(super) names: Vec<String>,
}

impl Parse for Operands {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let (mut values, mut names) = (Vec::new(), Vec::new());
        if input.peek(Ident) && input.peek2(Token![;]) && input.fork().parse::<Ident>()? == "biased" {
            // `join!(biased; a, b)` polls in the order written.
            input.parse::<Ident>()?;
            input.parse::<Token![;]>()?;
        }
        while !input.is_empty() {
            if input.peek(Ident::peek_any) && input.peek2(Token![=]) && !input.peek2(Token![==]) {
                names.push(input.call(Ident::parse_any)?.unraw().to_string());
                input.parse::<Token![=]>()?;
            }
            values.push(input.parse()?);
            if input.is_empty() {
                break;
            }
            input.parse::<Token![,]>()?;
        }
        Ok(Self { values, names })
    }
}

/// `target: t, Level::INFO, name = a, other.name = ?b, %c, key:? = d; "{}", e`
pub(super) struct LogOperands(pub(super) Vec<Expr>);

impl Parse for LogOperands {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let mut operands = Vec::new();
        while !input.is_empty() {
            if input.peek(syn::token::Brace) && input.peek2(Token![=]) {
                // `{ NAME } = value`, where a constant names the field.
                input.parse::<proc_macro2::TokenTree>()?;
                input.parse::<Token![=]>()?;
                skip_capture(input)?;
                operands.push(input.parse()?);
            } else if input.peek(syn::token::Brace) {
                // `tracing::info!({ a = 1 }, "text")`
                let fields;
                syn::braced!(fields in input);
                operands.extend(Self::parse(&fields)?.0);
            } else {
                skip_field_name(input)?;
                skip_capture(input)?;
                operands.push(input.parse()?);
            }
            if input.is_empty() {
                break;
            }
            if input.parse::<Option<Token![;]>>()?.is_none() {
                input.parse::<Token![,]>()?;
            }
        }
        Ok(Self(operands))
    }
}

/// `name =`, `"name" =`, `a.b =`, `name:? =`, and `target:`-like words.
fn skip_field_name(input: ParseStream<'_>) -> syn::Result<()> {
    let ahead = input.fork();
    if ahead.peek(syn::LitStr) {
        ahead.parse::<syn::LitStr>()?;
    } else if ahead.peek(Ident::peek_any) {
        ahead.call(Ident::parse_any)?;
        while ahead.peek(Token![.]) && ahead.peek2(Ident::peek_any) {
            ahead.parse::<Token![.]>()?;
            ahead.call(Ident::parse_any)?;
        }
    } else {
        return Ok(());
    }
    if ahead.peek(Token![:]) && !ahead.peek(Token![::]) {
        ahead.parse::<Token![:]>()?;
        let word = ahead.peek(Ident) && ahead.peek2(Token![=]);
        if word {
            ahead.parse::<Ident>()?;
        } else {
            skip_capture(&ahead)?;
        }
        if !ahead.peek(Token![=]) || ahead.peek(Token![==]) {
            // `target: "motor"`: the operand begins behind the colon.
            input.call(Ident::parse_any)?;
            input.parse::<Token![:]>()?;
            return Ok(());
        }
    }
    if ahead.peek(Token![=]) && !ahead.peek(Token![==]) && !ahead.peek(Token![=>]) {
        ahead.parse::<Token![=]>()?;
        syn::parse::discouraged::Speculative::advance_to(input, &ahead);
    }
    Ok(())
}

/// The `?` or `%` before a value that is recorded.
fn skip_capture(input: ParseStream<'_>) -> syn::Result<()> {
    if input.peek(Token![?]) {
        input.parse::<Token![?]>()?;
    } else if input.peek(Token![%]) {
        input.parse::<Token![%]>()?;
    }
    Ok(())
}

/// `value, pattern if guard`, and a message in assertions
pub(super) struct MatchesOperands {
    pub(super) value: Expr,
    pub(super) pat: Pat,
    pub(super) guard: Option<Expr>,
    pub(super) message: Operands,
}

impl Parse for MatchesOperands {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let value = input.parse()?;
        input.parse::<Token![,]>()?;
        let pat = Pat::parse_multi_with_leading_vert(input)?;
        let guard = match input.parse::<Option<Token![if]>>()? {
            Some(_) => Some(input.parse()?),
            None => None,
        };
        if !input.is_empty() {
            input.parse::<Token![,]>()?;
        }
        Ok(Self { value, pat, guard, message: input.parse()? })
    }
}

/// `a, b` or `value; len`
pub(super) enum VecOperands {
    List(Vec<Expr>),
    Repeat(Box<Expr>, Box<Expr>),
}

impl Parse for VecOperands {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let mut elements = Vec::new();
        while !input.is_empty() {
            let element: Expr = input.parse()?;
            if elements.is_empty() && input.parse::<Option<Token![;]>>()?.is_some() {
                return Ok(Self::Repeat(Box::new(element), input.parse()?));
            }
            elements.push(element);
            if input.is_empty() {
                break;
            }
            input.parse::<Token![,]>()?;
        }
        Ok(Self::List(elements))
    }
}

/// `a, b; c, d`: rows of elements, which are also written as `[a, b], [c, d]`.
pub(super) struct RowOperands(Vec<Vec<Expr>>);

impl RowOperands {
    /// All elements, in the order in which they are evaluated.
    pub(super) fn elements(self, by_column: bool) -> Vec<Expr> {
        let Self(rows) = self;
        if !by_column {
            return rows.into_iter().flatten().flat_map(within_brackets).collect();
        }
        let width = rows.iter().map(Vec::len).max().unwrap_or(0);
        (0..width).flat_map(|column| rows.iter().filter_map(move |row| row.get(column).cloned())).collect()
    }
}

impl Parse for RowOperands {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let (mut rows, mut row) = (Vec::new(), Vec::new());
        while !input.is_empty() {
            row.push(input.parse()?);
            if input.parse::<Option<Token![;]>>()?.is_some() {
                rows.push(std::mem::take(&mut row));
            } else if !input.is_empty() {
                input.parse::<Token![,]>()?;
            }
        }
        rows.push(row);
        Ok(Self(rows))
    }
}

/// The elements of nested rows in brackets.
fn within_brackets(element: Expr) -> Vec<Expr> {
    match element {
        Expr::Array(row) => row.elems.into_iter().flat_map(within_brackets).collect(),
        element => vec![element],
    }
}
