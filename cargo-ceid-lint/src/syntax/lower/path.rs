//! Paths and their arguments. Never resolves them.

use quote::ToTokens as _;

use super::{Lowerer, name};
use crate::source::Span;
use crate::syntax::text::tokens_text;
use crate::syntax::tree::{Bound, ConstText, GenericArg, Path, Segment, TypeRef};

impl Lowerer<'_, '_> {
    pub(super) fn path(&self, qself: Option<&syn::QSelf>, path: &syn::Path) -> Path {
        let segments = path
            .segments
            .iter()
            .map(|segment| Segment { name: name(&segment.ident), args: self.path_arguments(&segment.arguments) });
        Path {
            self_ty: qself.map(|qself| Box::new(self.ty(&qself.ty))),
            trait_segments: qself.map_or(0, |qself| qself.position),
            // In `<T>::name`, the `::` belongs to the type before it.
            global: path.leading_colon.is_some() && qself.is_none_or(|qself| qself.position > 0),
            segments: segments.collect(),
        }
    }

    fn path_arguments(&self, arguments: &syn::PathArguments) -> Vec<GenericArg> {
        match arguments {
            syn::PathArguments::None => Vec::new(),
            syn::PathArguments::AngleBracketed(angle) => self.generic_args(angle),
            syn::PathArguments::Parenthesized(paren) => {
                let inputs = paren.inputs.iter().map(|input| self.ty(&input.ty)).collect();
                let output = self.return_type(&paren.output);
                vec![GenericArg::Type(TypeRef::Tuple(inputs)), GenericArg::Assoc("Output".to_owned(), output)]
            }
        }
    }

    pub(super) fn generic_args(&self, angle: &syn::AngleBracketedGenericArguments) -> Vec<GenericArg> {
        angle.args.iter().filter_map(|arg| self.generic_arg(arg)).collect()
    }

    /// `None` for lifetimes.
    fn generic_arg(&self, arg: &syn::GenericArgument) -> Option<GenericArg> {
        Some(match arg {
            syn::GenericArgument::Lifetime(_) => return None,
            syn::GenericArgument::Type(ty) => GenericArg::Type(self.ty(ty)),
            syn::GenericArgument::Const(value) => GenericArg::Const(const_text(value)),
            syn::GenericArgument::AssocType(assoc) => GenericArg::Assoc(name(&assoc.ident), self.ty(&assoc.ty)),
            syn::GenericArgument::Constraint(constraint) => {
                GenericArg::Constraint(name(&constraint.ident), self.bounds(&constraint.bounds))
            }
            syn::GenericArgument::AssocConst(assoc) => GenericArg::Assoc(name(&assoc.ident), TypeRef::Unknown),
            _ => GenericArg::Type(TypeRef::Unknown),
        })
    }

    pub(super) fn bounds<'b>(&self, bounds: impl IntoIterator<Item = &'b syn::TypeParamBound>) -> Vec<Bound> {
        let traits = bounds.into_iter().filter_map(|bound| match bound {
            syn::TypeParamBound::Trait(bound) if bound.maybe.is_none() => Some(self.path(None, &bound.path)),
            _ => None,
        });
        traits.collect()
    }

    pub(in crate::syntax) fn path_span(&self, path: &syn::Path) -> Span {
        let first = match (&path.leading_colon, path.segments.first()) {
            (Some(colon), _) => self.span(colon.spans[0]),
            (None, Some(segment)) => self.span(segment.ident.span()),
            (None, None) => Span::new(self.file, 0, 0),
        };
        let Some(last) = path.segments.last() else { return first };
        let end = match &last.arguments {
            syn::PathArguments::None => self.span(last.ident.span()),
            syn::PathArguments::AngleBracketed(angle) => self.span(angle.gt_token.span),
            syn::PathArguments::Parenthesized(paren) => match &paren.output {
                syn::ReturnType::Default => self.span(paren.paren_token.span.close()),
                syn::ReturnType::Type(_, ty) => self.type_span(ty),
            },
        };
        first.to(end)
    }

    pub(super) fn qualified_span(&self, qself: Option<&syn::QSelf>, path: &syn::Path) -> Span {
        match qself {
            Some(qself) => self.span(qself.lt_token.span).to(self.path_span(path)),
            None => self.path_span(path),
        }
    }
}

/// The spelling of a constant, its value if it is an integer literal, and its sides if it is arithmetic.
pub(super) fn const_text(value: &syn::Expr) -> ConstText {
    let integer = match bare(value) {
        syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Int(int), .. }) => int.base10_parse().ok(),
        _ => None,
    };
    let sides = match bare(value) {
        syn::Expr::Binary(binary) => operator(&binary.op)
            .map(|operator| Box::new((operator, const_text(&binary.left), const_text(&binary.right)))),
        _ => None,
    };
    ConstText { text: tokens_text(&value.to_token_stream()), value: integer, sides }
}

fn operator(operator: &syn::BinOp) -> Option<&'static str> {
    match operator {
        syn::BinOp::Add(_) => Some("+"),
        syn::BinOp::Sub(_) => Some("-"),
        syn::BinOp::Mul(_) => Some("*"),
        syn::BinOp::Div(_) => Some("/"),
        _ => None,
    }
}

/// The expression inside parentheses, or alone in a block.
fn bare(value: &syn::Expr) -> &syn::Expr {
    match value {
        syn::Expr::Paren(paren) => bare(&paren.expr),
        syn::Expr::Group(group) => bare(&group.expr),
        syn::Expr::Block(block) => match block.block.stmts.as_slice() {
            [syn::Stmt::Expr(only, None)] => bare(only),
            _ => value,
        },
        _ => value,
    }
}
