//! Literals and operators as data. Never evaluates anything.

use quote::ToTokens as _;

use crate::syntax::tree::Literal;

pub(super) fn literal(literal: &syn::Lit) -> Literal {
    match literal {
        syn::Lit::Int(int) => Literal::Int(int.base10_digits().parse().ok(), int.suffix().to_owned()),
        syn::Lit::Float(float) => Literal::Float(float.to_string()),
        syn::Lit::Bool(bool) => Literal::Bool(bool.value),
        syn::Lit::Str(text) => Literal::Str(text.value()),
        syn::Lit::Char(char) => Literal::Char(char.value()),
        syn::Lit::Byte(byte) => Literal::Int(Some(byte.value().into()), "u8".to_owned()),
        syn::Lit::ByteStr(bytes) => Literal::Bytes(format!("{:?}", bytes.value())),
        other => Literal::Bytes(other.to_token_stream().to_string()),
    }
}

/// The operator without a final `=` that makes it an assignment, and whether there is one.
pub(super) fn operator(op: &syn::BinOp) -> Option<(&'static str, bool)> {
    use syn::BinOp;
    Some(match op {
        BinOp::Add(_) => ("+", false),
        BinOp::Sub(_) => ("-", false),
        BinOp::Mul(_) => ("*", false),
        BinOp::Div(_) => ("/", false),
        BinOp::Rem(_) => ("%", false),
        BinOp::And(_) => ("&&", false),
        BinOp::Or(_) => ("||", false),
        BinOp::BitXor(_) => ("^", false),
        BinOp::BitAnd(_) => ("&", false),
        BinOp::BitOr(_) => ("|", false),
        BinOp::Shl(_) => ("<<", false),
        BinOp::Shr(_) => (">>", false),
        BinOp::Eq(_) => ("==", false),
        BinOp::Lt(_) => ("<", false),
        BinOp::Le(_) => ("<=", false),
        BinOp::Ne(_) => ("!=", false),
        BinOp::Ge(_) => (">=", false),
        BinOp::Gt(_) => (">", false),
        BinOp::AddAssign(_) => ("+", true),
        BinOp::SubAssign(_) => ("-", true),
        BinOp::MulAssign(_) => ("*", true),
        BinOp::DivAssign(_) => ("/", true),
        BinOp::RemAssign(_) => ("%", true),
        BinOp::BitXorAssign(_) => ("^", true),
        BinOp::BitAndAssign(_) => ("&", true),
        BinOp::BitOrAssign(_) => ("|", true),
        BinOp::ShlAssign(_) => ("<<", true),
        BinOp::ShrAssign(_) => (">>", true),
        _ => return None,
    })
}
