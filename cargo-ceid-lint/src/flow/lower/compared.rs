//! Comparisons that are spelled as methods: `a.lt(&b)`, `a.cmp(&b).is_lt()`, and what is asked of how two values stand to each other.

use super::Builder;
use super::conditions::Compared;
use super::orders::{ORDERS as NUMBER_ORDERS, orders_asked};
use super::subjects::Pure;
use crate::flow::{AskedNumber, Head, NodeId};
use crate::index::Ty;
use crate::syntax::tree::{ExprId, ExprKind};
use crate::types::Callee;

/// The operators that methods of numbers stand for.
const METHODS: &[(&str, &str)] = &[("lt", "<"), ("le", "<="), ("gt", ">"), ("ge", ">="), ("eq", "=="), ("ne", "!=")];

/// Operators of comparison, each with the one that asks the same with its sides exchanged, and the one that asks the opposite.
const OPERATORS: &[[&str; 3]] =
    &[["==", "==", "!="], ["!=", "!=", "=="], ["<", ">", ">="], [">", "<", "<="], ["<=", ">=", ">"], [">=", "<=", "<"]];

/// How two values may stand to each other.
const ORDERS: [&str; 3] = ["Less", "Equal", "Greater"];

impl Builder<'_> {
    /// Asks what a method asks that compares. Answers whether it is one.
    pub(super) fn spelled_comparison(
        &mut self,
        id: ExprId,
        receiver: ExprId,
        method: &str,
        args: &[ExprId],
        no: NodeId,
    ) -> bool {
        if matches!(self.typed().callees.get(&id), Some(Callee::Resolved(_))) {
            return false;
        }
        match args {
            [other] => {
                let op = METHODS.iter().find(|(name, _)| *name == method).map(|(_, op)| *op);
                let is_number = matches!(self.ty(receiver).peel(), Ty::Int | Ty::Float | Ty::Char);
                let Some(op) = op.filter(|_| is_number) else { return false };
                self.comparison(id, op, receiver, *other, no);
                true
            }
            [] => {
                let Some(name) = method.strip_prefix("is_") else { return false };
                let Some((_, op)) = METHODS.iter().find(|(own, _)| *own == name) else { return false };
                match self.compared_numbers(receiver) {
                    Some([left, right]) => {
                        self.comparison(id, op, left, right, no);
                        true
                    }
                    None => self.order_asked(id, receiver, op, no),
                }
            }
            _ => false,
        }
    }

    /// What a comparison asks about, in one spelling: `a != X` is `a == X` turned round, `a >= b` is `a < b` turned round.
    pub(super) fn compared(&mut self, op: &str, lhs: ExprId, rhs: ExprId) -> (Option<Compared>, Vec<Head>, bool) {
        let negated = matches!(op, "!=" | ">=" | ">");
        // Which variant two states are is asked of the states.
        let told = self.told_variant(lhs).zip(self.told_variant(rhs)).filter(|_| matches!(op, "==" | "!="));
        let (lhs, rhs) = told.unwrap_or((lhs, rhs));
        if matches!(op, "==" | "!=") {
            // Of an equality of its own, nothing is known but that it is the same for the same values.
            let is_faithful = told.is_some() || self.tells_variants_apart(self.ty(lhs));
            for (subject, constant) in [(lhs, rhs), (rhs, lhs)] {
                if is_faithful
                    && self.constants().is_exact(constant)
                    && let Some(head) = self.constant_head(constant)
                    && !matches!(self.body().expr(subject).kind, ExprKind::Literal(_))
                    && let Some(pure) = self.pure(subject)
                {
                    let total = self.all_heads(subject);
                    return (Some((pure, total)), vec![head], negated);
                }
            }
        }
        let (Some(left), Some(right)) = (self.pure(lhs), self.pure(rhs)) else {
            return (None, Vec::new(), false);
        };
        let of_its_own = told.is_none() && [lhs, rhs].iter().any(|side| self.has_own_operator(self.ty(*side), op));
        if of_its_own {
            let key = format!("({} of its own {op} {})", left.key, right.key);
            let reads = [left.reads, right.reads].concat();
            let total = Some(vec!["true".to_owned(), "false".to_owned()]);
            return (Some((Pure { key, reads, ..Pure::default() }, total)), vec!["true".to_owned()], false);
        }
        let is_partial = [lhs, rhs].iter().any(|side| self.may_be_unordered(self.ty(*side)));
        let is_partial = is_partial && !self.are_numbers([lhs, rhs]);
        if let Some(orders) = orders_asked(op).filter(|_| is_partial) {
            let key = format!("({} <=> {})", left.key, right.key);
            let reads = [left.reads, right.reads].concat();
            let to_heads = |orders: &[&str]| orders.iter().map(|order| (*order).to_owned()).collect();
            return (
                Some((Pure { key, reads, ..Pure::default() }, Some(to_heads(&NUMBER_ORDERS)))),
                to_heads(orders),
                false,
            );
        }
        let (symbol, negated) = match op {
            "==" | "!=" => ("==", op == "!="),
            ">=" => ("<", true),
            ">" => ("<=", true),
            other => (other, false),
        };
        let is_same = told.is_some() || symbol != "==" || self.tells_variants_apart(self.ty(lhs));
        if symbol == "==" && is_same && self.is_state(self.ty(lhs)) {
            // What is known of one side is known of the other where they are equal.
            for side in [&left, &right] {
                if side.whole.is_some() {
                    self.state_subject(side.clone(), lhs);
                }
            }
        }
        let mut reads = left.reads;
        reads.extend(right.reads);
        let variant = if told.is_some() { "the variant of " } else { "" };
        let symbol = if is_same { symbol } else { "equals" };
        let key = format!("({variant}{} {symbol} {})", left.key, right.key);
        let total = Some(vec!["true".to_owned(), "false".to_owned()]);
        (Some((Pure { key, reads, ..Pure::default() }, total)), vec!["true".to_owned()], negated)
    }

    /// The number that a place is compared with; `is_turned` if what holds on the first edge is the opposite.
    pub(super) fn number_asked(&mut self, op: &str, sides: [ExprId; 2], is_turned: bool) -> Option<AskedNumber> {
        let [left, right] = sides.map(|side| self.constants().asked_number(side));
        let (asked, number, is_mirrored) = match (left, right) {
            (None, Some(number)) => (sides[0], number, false),
            (Some(number), None) => (sides[1], number, true),
            _ => return None,
        };
        let of = self.pure(asked).and_then(|pure| pure.whole).filter(|_| *self.ty(asked).peel() == Ty::Int)?;
        let number = format!("{number}").parse().ok()?;
        let op = OPERATORS.iter().find(|own| own[0] == op)?;
        let op = OPERATORS.iter().find(|own| own[0] == op[usize::from(is_mirrored)])?;
        Some(AskedNumber { of, op: op[if is_turned { 2 } else { 0 }], number })
    }

    /// The numbers of which a call tells how they stand to each other: `a.cmp(&b)`.
    fn compared_numbers(&self, id: ExprId) -> Option<[ExprId; 2]> {
        let ExprKind::MethodCall { receiver, method, args, .. } = &self.body().expr(id).kind else { return None };
        let [other] = args.as_slice() else { return None };
        let is_own = matches!(self.typed().callees.get(&id), Some(Callee::Resolved(_)));
        let are_whole = matches!(self.ty(*receiver).peel(), Ty::Int | Ty::Char);
        (method == "cmp" && are_whole && !is_own).then_some([*receiver, *other])
    }

    /// `a.cmp(&b) == Ordering::Less` compares the two.
    pub(super) fn compared_order(&self, op: &str, sides: [ExprId; 2]) -> Option<(&'static str, [ExprId; 2])> {
        let [left, right] = sides;
        let (numbers, order) = match self.compared_numbers(left) {
            Some(numbers) => (numbers, right),
            None => (self.compared_numbers(right)?, left),
        };
        let op = match (op, self.constant_head(order)?.as_str()) {
            ("==", "Less") => "<",
            ("!=", "Less") => ">=",
            ("==", "Equal") => "==",
            ("!=", "Equal") => "!=",
            ("==", "Greater") => ">",
            ("!=", "Greater") => "<=",
            _ => return None,
        };
        Some((op, numbers))
    }

    /// `order.is_ge()` asks the same of it as patterns do.
    fn order_asked(&mut self, id: ExprId, order: ExprId, op: &str, no: NodeId) -> bool {
        let Some(pure) = self.pure(order) else { return false };
        let (span, text, about) = (self.span(id), self.text(id), self.about(id));
        self.expr(order);
        if self.at.is_none() {
            return true;
        }
        let heads = ORDERS.map(str::to_owned);
        let asked = self.subject(pure, Some(heads.to_vec()));
        for head in &heads {
            self.head_bit(asked, head);
        }
        let subject = &mut self.graph.subjects[asked.0 as usize];
        subject.total.get_or_insert_with(|| heads.to_vec());
        let held: Vec<Head> = heads.into_iter().filter(|head| holds(op, head)).collect();
        let (yes, failed) = self.branch_on_subject(asked, &held, true, span, text, about);
        self.link(failed, no);
        self.resume(yes);
        true
    }
}

/// Whether a comparison holds for values that stand to each other like this.
fn holds(op: &str, order: &str) -> bool {
    match op {
        "<" => order == "Less",
        "<=" => order != "Greater",
        ">" => order == "Greater",
        ">=" => order != "Less",
        "==" => order == "Equal",
        _ => order != "Equal",
    }
}
