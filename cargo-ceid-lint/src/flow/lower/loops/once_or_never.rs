//! Loops whose number of rounds lies in a variable that is one or none: `let mut due = 1; … due = 0; … for _ in 0..due { … }`. What runs
//! them asks for that number, as an `if` does.

use super::super::Builder;
use crate::flow::{About, NodeId, Var};
use crate::syntax::tree::{ExprId, ExprKind, PatKind, StmtKind};
use crate::types::LocalId;

impl Builder<'_> {
    /// The variable that says whether a `for` loop has a round, if its range ends there and it can be nothing but zero or one.
    pub(super) fn asks_for_round(&mut self, iterable: ExprId) -> Option<Var> {
        let ExprKind::Range { start: Some(start), end: Some(end), inclusive } = self.body().expr(iterable).kind else {
            return None;
        };
        if !matches!(self.body().expr(end).kind, ExprKind::Path(_)) || self.number(end).is_some() {
            return None;
        }
        let local = *self.typed().expr_local.get(&end)?;
        let is_whole = self.number(start) == Some(u64::from(inclusive)) && self.is_one_or_none(local);
        is_whole.then(|| self.var_of(local))
    }

    /// Goes on where such a loop has a round; answers where it has none.
    pub(super) fn ask_for_round(&mut self, var: Var, iterable: ExprId) -> NodeId {
        let (span, text, about) = (self.span(iterable), self.text(iterable), self.about(iterable));
        let about = About { is_presence: false, ..about };
        let (yes, no) = self.branch_on_number(var, &["1".to_owned()], span, text, about);
        self.resume(yes);
        no
    }

    /// Whether a local is given nothing but zero and one anywhere, and lent to nobody who may write it.
    fn is_one_or_none(&mut self, local: LocalId) -> bool {
        let body = self.body();
        let typed = self.typed();
        let is_it = |id: &ExprId| typed.expr_local.get(id) == Some(&local);
        let mut given = Vec::new();
        for expr in &body.exprs {
            match &expr.kind {
                ExprKind::Assign { place, value } if is_it(place) => given.push(*value),
                ExprKind::AssignOp { place, .. } if is_it(place) => return false,
                ExprKind::Reference { value, mutable: true, .. } if is_it(value) => return false,
                ExprKind::MethodCall { receiver, .. } if is_it(receiver) => return false,
                // What cannot be read may write anything that it names.
                ExprKind::Opaque(_) | ExprKind::Unknown { .. } => return false,
                ExprKind::Match { scrutinee: value, .. } | ExprKind::Let { value, .. } if is_it(value) => return false,
                ExprKind::Block(block) => {
                    for stmt in &block.stmts {
                        let StmtKind::Let { pat, init, .. } = &stmt.kind else { continue };
                        let is_bound = typed.pat_local.get(pat) == Some(&local);
                        if is_bound && matches!(body.pat(*pat).kind, PatKind::Bind { by_ref: false, sub: None, .. }) {
                            given.extend(*init);
                        } else if is_bound || init.as_ref().is_some_and(is_it) {
                            return false;
                        }
                    }
                }
                _ => {}
            }
        }
        !given.is_empty() && given.into_iter().all(|value| self.gives_one_or_none(value))
    }

    fn gives_one_or_none(&mut self, value: ExprId) -> bool {
        match &self.body().expr(value).kind {
            ExprKind::If { then, otherwise: Some(otherwise), .. } => {
                self.gives_one_or_none(*then) && self.gives_one_or_none(*otherwise)
            }
            ExprKind::Match { arms, .. } => arms.iter().all(|arm| self.gives_one_or_none(arm.body)),
            ExprKind::Block(block) => {
                block.label.is_none() && block.tail.is_some_and(|tail| self.gives_one_or_none(tail))
            }
            ExprKind::Literal(_) => self.number(value).is_some_and(|number| number < 2),
            _ => false,
        }
    }
}
