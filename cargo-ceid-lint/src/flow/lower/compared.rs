//! Comparisons that are spelled as methods: `a.lt(&b)`, `a.cmp(&b).is_lt()`, and what is asked of how two values stand to each other.

use super::Builder;
use crate::flow::{Head, NodeId};
use crate::index::Ty;
use crate::syntax::tree::{ExprId, ExprKind};
use crate::types::Callee;

/// The operators that methods of numbers stand for.
const METHODS: &[(&str, &str)] = &[("lt", "<"), ("le", "<="), ("gt", ">"), ("ge", ">="), ("eq", "=="), ("ne", "!=")];

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
