//! Collections of references in which there surely is something, so that a loop over them has a round.

use super::super::Builder;
use crate::index::Ty;
use crate::syntax::tree::{Body, ExprId, ExprKind, PatKind, Stmt, StmtKind};
use crate::types::LocalId;

impl Builder<'_> {
    /// Whether a loop over an expression has one round at least: `let mut all = vec![&mut roll, &mut pitch]; for filter in all.drain(..) { … }`.
    pub(in crate::flow::lower) fn is_surely_entered(&mut self, iterable: ExprId) -> bool {
        let named = match &self.body().expr(iterable).kind {
            ExprKind::Reference { value, .. } => *value,
            ExprKind::MethodCall { receiver, method, args, .. } => match method.as_str() {
                "iter" | "iter_mut" | "into_iter" | "as_mut_slice" | "pop" | "pop_front" | "pop_back" => *receiver,
                "drain" if self.is_full_range(args) => *receiver,
                _ => return false,
            },
            _ => iterable,
        };
        self.has_elements(named)
    }

    /// Whether a collection of references that is named has something in it, for it was filled in the same round and nothing was taken out
    /// before.
    pub(in crate::flow::lower) fn has_elements(&mut self, named: ExprId) -> bool {
        let Some(local) = self.typed().expr_local.get(&named).copied() else { return false };
        if !self.is_collection_of_references(self.ty(named)) {
            return false;
        }
        let var = self.var_of(local);
        let info = self.graph.var(var);
        if info.param.is_some() || info.in_loop != self.loops.last().copied() {
            return false;
        }
        let body = self.body();
        let Some((init, rest)) = self.declaration(local) else { return false };
        let is_filled = self.gives_elements(init) || rest.iter().any(|stmt| self.puts_into(stmt, local, named));
        let uses = (0..named.0).map(ExprId).filter(|id| self.typed().expr_local.get(id) == Some(&local));
        is_filled && uses.into_iter().all(|id| takes_nothing(body, id))
    }

    /// The value with which a local is declared, and the statements that follow in the same block.
    fn declaration(&self, local: LocalId) -> Option<(ExprId, &[Stmt])> {
        let blocks = self.body().exprs.iter().filter_map(|expr| match &expr.kind {
            ExprKind::Block(block) => Some(&block.stmts),
            _ => None,
        });
        blocks.into_iter().find_map(|stmts| {
            stmts.iter().enumerate().find_map(|(at, stmt)| match &stmt.kind {
                StmtKind::Let { pat, init: Some(init), otherwise: None, .. } if stmt.cfg.is_none() => {
                    let is_it = self.typed().pat_local.get(pat) == Some(&local)
                        && matches!(self.body().pat(*pat).kind, PatKind::Bind { sub: None, .. });
                    is_it.then(|| (*init, &stmts[at + 1..]))
                }
                _ => None,
            })
        })
    }

    /// Whether a value surely has elements, or is made of one that does.
    fn gives_elements(&self, value: ExprId) -> bool {
        if matches!(self.ty(value).peel(), Ty::Array(_, length) if length.value.is_some_and(|length| length > 0)) {
            return true;
        }
        match &self.body().expr(value).kind {
            ExprKind::Array { elements, .. } => !elements.is_empty(),
            ExprKind::MethodCall { receiver, method, args, .. } if args.is_empty() => {
                matches!(
                    method.as_str(),
                    "into_iter" | "iter_mut" | "rev" | "collect" | "into" | "into_vec" | "to_vec" | "each_mut"
                ) && self.gives_elements(*receiver)
            }
            ExprKind::Call { callee, args } => {
                let is_from = matches!(&self.body().expr(*callee).kind, ExprKind::Path(path) if path.last() == "from");
                matches!(args.as_slice(), [arg] if is_from && self.gives_elements(*arg))
            }
            _ => false,
        }
    }

    /// Whether a statement before an expression puts something into a collection.
    fn puts_into(&self, stmt: &Stmt, local: LocalId, before: ExprId) -> bool {
        let StmtKind::Expr { expr, .. } = &stmt.kind else { return false };
        let ExprKind::MethodCall { receiver, method, .. } = &self.body().expr(*expr).kind else { return false };
        stmt.cfg.is_none()
            && *expr < before
            && matches!(method.as_str(), "push" | "push_back" | "push_front")
            && self.typed().expr_local.get(receiver) == Some(&local)
    }
}

/// Whether nothing is taken out of a collection where it is named.
fn takes_nothing(body: &Body, named: ExprId) -> bool {
    body.exprs.iter().any(|expr| match &expr.kind {
        ExprKind::MethodCall { receiver, method, .. } if *receiver == named => matches!(
            method.as_str(),
            "push"
                | "push_back"
                | "push_front"
                | "extend"
                | "iter"
                | "iter_mut"
                | "len"
                | "is_empty"
                | "reverse"
                | "swap"
                | "rotate_left"
                | "rotate_right"
                | "first"
                | "last"
                | "first_mut"
                | "last_mut"
                | "front_mut"
                | "back_mut"
                | "get_mut"
                | "as_mut_slice"
        ),
        ExprKind::Index { base, .. } => *base == named,
        ExprKind::For { iterable, .. } => {
            matches!(&body.expr(*iterable).kind, ExprKind::Reference { value, .. } if *value == named)
        }
        _ => false,
    })
}
