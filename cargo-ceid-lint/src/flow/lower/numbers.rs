//! Whole numbers and characters that the source fixes, for telling how a value stands to them.

use super::constants::{Constants, in_constant};
use crate::flow::Head;
use crate::index::{Def, Ty};
use crate::syntax::tree::{ExprId, ExprKind, Literal};

/// How deep names and operators are followed.
const MAX_DEPTH: u32 = 32;

/// The greatest number up to which all whole ones are floats too.
const MAX_EXACT: i128 = 1 << 53;

impl Constants<'_> {
    /// The number that a value is compared with: a whole one that the source fixes, a character, or a float that is written out.
    pub(super) fn asked_number(self, id: ExprId) -> Option<f64> {
        if let ExprKind::Reference { value, .. } = &self.body.expr(id).kind {
            return self.asked_number(*value);
        }
        if *self.typed.ty(id).peel() == Ty::Float {
            return self.written_number(id);
        }
        match self.whole_number(id) {
            Some(number) => as_float(number),
            None => self.letter(id).or_else(|| self.written_number(id)),
        }
    }

    /// Whether what a value is compared with is a whole number or a character.
    pub(super) fn is_whole(self, id: ExprId) -> bool {
        self.whole_number(id).is_some() || self.letter(id).is_some()
    }

    /// The number of the character that an expression is.
    fn letter(self, id: ExprId) -> Option<f64> {
        match &self.body.expr(id).kind {
            ExprKind::Literal(Literal::Char(letter)) => Some(f64::from(u32::from(*letter))),
            ExprKind::Path(_) if *self.typed.ty(id).peel() == Ty::Char => number_of_head(&self.head(id)?),
            _ => None,
        }
    }

    /// The whole number that an expression of literals and constants is.
    pub(super) fn whole_number(self, id: ExprId) -> Option<i128> {
        self.whole_number_at(id, 0)
    }

    fn whole_number_at(self, id: ExprId, depth: u32) -> Option<i128> {
        if depth > MAX_DEPTH {
            return None;
        }
        let next = |id: ExprId| self.whole_number_at(id, depth + 1);
        match &self.body.expr(id).kind {
            ExprKind::Literal(Literal::Int(Some(value), _)) => Some(i128::from(*value)),
            ExprKind::Negate(inner) => next(*inner)?.checked_neg(),
            ExprKind::Block(block) if block.stmts.is_empty() && block.label.is_none() => next(block.tail?),
            ExprKind::Binary { op, lhs, rhs } => {
                let (left, right) = (next(*lhs)?, next(*rhs)?);
                match *op {
                    "+" => left.checked_add(right),
                    "-" => left.checked_sub(right),
                    "*" => left.checked_mul(right),
                    "/" => left.checked_div(right),
                    "%" => left.checked_rem(right),
                    _ => None,
                }
            }
            ExprKind::Path(path) => match self.typed.expr_def.get(&id) {
                Some(Def::Value(value)) if !self.program.index.value(*value).item.is_static => {
                    let whole = |own: Constants<'_>| own.whole_number_at(own.body.root, depth + 1);
                    in_constant(self.program, *value, whole)?
                }
                _ if self.typed.expr_local.contains_key(&id) => None,
                _ => limit_of_type(&path.text()),
            },
            _ => None,
        }
    }
}

/// The least or greatest number of a type that every machine has alike: `i32::MIN`, `u8::MAX`.
pub(super) fn limit_of_type(path: &str) -> Option<i128> {
    let (owner, limit) = path.rsplit_once("::")?;
    let name = owner.rsplit("::").next()?;
    let bits = bits_of(name)?;
    let is_signed = name.starts_with('i');
    match (limit, is_signed) {
        ("MIN", true) => Some(-(1 << (bits - 1))),
        ("MIN", false) => Some(0),
        ("MAX", true) => Some((1 << (bits - 1)) - 1),
        ("MAX", false) => Some((1 << bits) - 1),
        _ => None,
    }
}

/// The least and greatest number of a type of whole numbers.
pub(super) fn limits_of(name: &str) -> Option<[f64; 2]> {
    let limit = |end: &str| as_float(limit_of_type(&format!("{name}::{end}"))?);
    Some([limit("MIN")?, limit("MAX")?])
}

/// The number that a head stands for.
pub(super) fn number_of_head(head: &Head) -> Option<f64> {
    if let Some(letter) = head.strip_prefix('\'').and_then(|rest| rest.strip_suffix('\'')) {
        return letter_of(letter).map(|letter| f64::from(u32::from(letter)));
    }
    match head.parse::<i128>() {
        Ok(number) => as_float(number),
        Err(_) => head.parse::<f64>().ok().filter(|number| !number.is_nan()),
    }
}

/// The character that is spelled so between quotes.
fn letter_of(text: &str) -> Option<char> {
    let mut letters = text.chars();
    match (letters.next()?, letters.next(), letters.next()) {
        (letter, None, _) => Some(letter),
        ('\\', Some('n'), None) => Some('\n'),
        ('\\', Some('r'), None) => Some('\r'),
        ('\\', Some('t'), None) => Some('\t'),
        ('\\', Some('0'), None) => Some('\0'),
        ('\\', Some(letter @ ('\\' | '\'' | '"')), None) => Some(letter),
        _ => {
            let digits = text.strip_prefix("\\u{")?.strip_suffix('}')?;
            char::from_u32(u32::from_str_radix(digits, 16).ok()?)
        }
    }
}

/// A whole number as a float, where no other one is the same float.
fn as_float(number: i128) -> Option<f64> {
    let is_limit = || {
        let of_type = |bits: u32| [(1 << (bits - 1)) - 1, -(1 << (bits - 1)), (1 << bits) - 1];
        [8, 16, 32, 64].into_iter().flat_map(of_type).any(|limit: i128| limit == number)
    };
    if number.unsigned_abs() > MAX_EXACT.unsigned_abs() && !is_limit() {
        return None;
    }
    format!("{number}").parse().ok()
}

fn bits_of(name: &str) -> Option<u32> {
    match name.strip_prefix(['u', 'i'])? {
        "8" => Some(8),
        "16" => Some(16),
        "32" => Some(32),
        "64" => Some(64),
        _ => None,
    }
}
