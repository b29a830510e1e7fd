//! Numbers that are compared with one another in several ways: `a < b`, `b <= a` and `a == b` are answers to one question.

mod partial;

use super::Builder;
use super::questions::grouped;
use super::subjects::Pure;
use crate::flow::{Head, SubjectId};
use crate::index::Ty;
use crate::syntax::tree::ExprId;

/// A comparison of two values that are no constants of the same kind of head.
#[derive(Clone, Debug)]
pub(super) struct Order {
    left: String,
    right: String,
    reads: Vec<crate::flow::Place>,
    is_float: bool,
    asks: Asks,
}

/// What the subject of a comparison tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asks {
    Less,
    AtMost,
    Equal,
    /// How two floats stand to each other.
    Order,
}

/// How two numbers may stand to each other: with NaN on a side, no comparison of floats holds.
pub(super) const ORDERS: [&str; 4] = ["less", "equal", "greater", "unordered"];

impl Builder<'_> {
    /// Notes that a comparison asks how two numbers stand to each other.
    pub(super) fn note_order(&mut self, subject: SubjectId, op: &str, lhs: ExprId, rhs: ExprId) {
        let [left_ty, right_ty] = [lhs, rhs].map(|side| self.ty(side).peel().clone());
        let is_float = self.may_be_unordered(&left_ty) || self.may_be_unordered(&right_ty);
        let has_order = |ty: &Ty| !matches!(ty, Ty::Unknown | Ty::Var(_));
        let is_of_its_own = [&left_ty, &right_ty].iter().any(|ty| self.has_own_operator(ty, op));
        // What is compared with a constant for being equal is asked for its value.
        let is_constant = |side: ExprId| self.constant_head(side).is_some();
        let asks = match op {
            "==" | "!=" if is_constant(lhs) || is_constant(rhs) => return,
            // What an equality compares need not be what an order does.
            "==" | "!=" if matches!(left_ty, Ty::Adt(..)) => return,
            "==" | "!=" => Asks::Equal,
            _ if is_float => Asks::Order,
            "<" | ">=" => Asks::Less,
            _ => Asks::AtMost,
        };
        if !has_order(&left_ty) || !has_order(&right_ty) || is_of_its_own {
            return;
        }
        let (Some(left), Some(right)) = (self.pure(lhs), self.pure(rhs)) else { return };
        let reads = [left.reads, right.reads].concat();
        self.orders.insert(subject, Order { left: left.key, right: right.key, reads, is_float, asks });
    }

    /// Asks all comparisons of the same two numbers how these stand to each other.
    pub(super) fn settle_orders(&mut self) {
        let pair_of = |order: &Order| {
            let mut pair = [order.left.clone(), order.right.clone()];
            pair.sort();
            pair
        };
        for (pair, asked) in grouped(std::mem::take(&mut self.orders), pair_of) {
            let [(_, first), _, ..] = asked.as_slice() else { continue };
            // Two whole numbers always stand to each other in some way.
            let orders = if asked.iter().any(|(_, order)| order.is_float) { &ORDERS[..] } else { &ORDERS[..3] };
            let heads: Vec<Head> = orders.iter().map(|order| (*order).to_owned()).collect();
            let key = format!("({} against {})", pair[0], pair[1]);
            let between = Pure { key, reads: first.reads.clone(), ..Pure::default() };
            self.ask_as_one(between, &heads, &asked, |order, at| order.head(&heads[at], order.left != pair[0]));
        }
    }
}

impl Order {
    /// The same question with other names for the values.
    pub(super) fn renamed(&self, name: impl Fn(&str) -> String, reads: Vec<crate::flow::Place>) -> Self {
        Self { left: name(&self.left), right: name(&self.right), reads, ..self.clone() }
    }

    /// The head that the subject of the comparison has where the numbers stand to each other like this; `is_turned` if they do so the
    /// other way round.
    fn head(&self, between: &str, is_turned: bool) -> Head {
        let own = match between {
            "less" if is_turned => "greater",
            "greater" if is_turned => "less",
            same => same,
        };
        let holds = match self.asks {
            Asks::Order => return own.to_owned(),
            Asks::Less => own == "less",
            Asks::AtMost => matches!(own, "less" | "equal"),
            Asks::Equal => own == "equal",
        };
        holds.to_string()
    }
}

/// Of which orders a comparison of floats asks.
pub(super) fn orders_asked(op: &str) -> Option<&'static [&'static str]> {
    match op {
        "<" => Some(&["less"]),
        "<=" => Some(&["less", "equal"]),
        ">" => Some(&["greater"]),
        ">=" => Some(&["equal", "greater"]),
        _ => None,
    }
}
