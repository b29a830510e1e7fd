//! Collections of references of which it is known what is in them: a loop over those that are not empty has a round.

use super::super::Builder;
use crate::flow::IndexKey;
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
        let Some((init, rest)) = self.declaration(local) else { return false };
        let is_filled =
            self.elements_of(init).is_some_and(|count| count > 0) || self.pushes(rest, local, named).next().is_some();
        is_filled && self.uses_before(local, named).all(|id| use_of(self.body(), id) != Use::Other)
    }

    /// The key of an element that a method puts into a collection: its number, if all that were put there before are there for sure.
    pub(in crate::flow::lower) fn new_key(&mut self, receiver: ExprId, method: &str) -> IndexKey {
        let number = if matches!(method, "push" | "push_back") { self.next_number(receiver) } else { None };
        number.map_or_else(|| IndexKey::Data("the new element".into()), IndexKey::Number)
    }

    /// The number of the next element behind those of a collection of references, which is how many there are: if all that were put
    /// there are there for sure, each in its place.
    pub(in crate::flow::lower) fn next_number(&mut self, named: ExprId) -> Option<u64> {
        let local = self.typed().expr_local.get(&named).copied()?;
        let ty = self.ty(named);
        if !self.is_collection_of_references(ty) || matches!(ty, Ty::Ref(..)) || is_heap(ty) {
            return None;
        }
        let var = self.var_of(local);
        let info = self.graph.var(var);
        if info.param.is_some() || info.in_loop != self.loops.last().copied() {
            return None;
        }
        let (init, rest) = self.declaration(local)?;
        let emptied = self.last_emptied(rest, local, named);
        let first = if emptied.is_some() { 0 } else { self.elements_of(init)? };
        let is_since = |id: ExprId| emptied.is_none_or(|emptied| id > emptied);
        let mut before: Vec<(ExprId, u64)> = self.pushes(rest, local, named).collect();
        before.retain(|(receiver, _)| is_since(*receiver));
        let is_known = |id: ExprId| {
            let use_of = use_of(self.body(), id);
            use_of == Use::Look || use_of != Use::Other && before.iter().any(|(receiver, _)| *receiver == id)
        };
        let is_plain = self.uses_before(local, named).filter(|id| is_since(*id)).all(is_known);
        is_plain.then_some(before.into_iter().fold(first, |all, (_, count)| all + count))
    }

    /// Where a local is named before an expression.
    fn uses_before(&self, local: LocalId, before: ExprId) -> impl Iterator<Item = ExprId> {
        let named = move |id: &ExprId| self.typed().expr_local.get(id) == Some(&local);
        (0..before.0).map(ExprId).filter(named)
    }

    /// Where statements that surely run put something behind the elements of a collection, before an expression; and how many.
    fn pushes(&self, rest: &[Stmt], local: LocalId, before: ExprId) -> impl Iterator<Item = (ExprId, u64)> {
        let pushed = move |stmt: &Stmt| {
            let StmtKind::Expr { expr, .. } = &stmt.kind else { return None };
            let ExprKind::MethodCall { receiver, method, args, .. } = &self.body().expr(*expr).kind else {
                return None;
            };
            let count = match (method.as_str(), args.as_slice()) {
                ("push" | "push_back", [_]) => 1,
                ("extend", [given]) => self.elements_of(*given).filter(|count| *count > 0)?,
                _ => return None,
            };
            let is_it = stmt.cfg.is_none() && *expr < before && self.typed().expr_local.get(receiver) == Some(&local);
            is_it.then_some((*receiver, count))
        };
        rest.iter().filter_map(pushed)
    }

    /// Where a statement that surely runs leaves nothing in a collection, the last one before an expression.
    fn last_emptied(&self, rest: &[Stmt], local: LocalId, before: ExprId) -> Option<ExprId> {
        let (body, typed) = (self.body(), self.typed());
        let is_it = |id: ExprId| typed.expr_local.get(&id) == Some(&local);
        let emptied = |stmt: &Stmt| {
            let StmtKind::Expr { expr, .. } = &stmt.kind else { return None };
            let (call, is_popped) = match &body.expr(*expr).kind {
                ExprKind::For { iterable, .. } => (*iterable, false),
                ExprKind::While { condition, body: inside, .. } => {
                    let ExprKind::Let { pat, value } = &body.expr(*condition).kind else { return None };
                    let PatKind::TupleStruct(_, inner) = &body.pat(*pat).kind else { return None };
                    let is_stopped = body
                        .within(*inside)
                        .any(|id| matches!(body.expr(id).kind, ExprKind::Break { .. }) || is_it(id));
                    (*value, !is_stopped && inner.iter().all(|inner| self.is_irrefutable(*inner)))
                }
                ExprKind::MethodCall { .. } => (*expr, false),
                _ => return None,
            };
            let ExprKind::MethodCall { receiver, method, args, .. } = &body.expr(call).kind else { return None };
            let is_emptied = match (method.as_str(), args.as_slice()) {
                ("drain", args) => self.is_full_range(args),
                ("pop" | "pop_front" | "pop_back", []) => is_popped,
                ("clear", []) => true,
                _ => false,
            };
            (is_emptied && stmt.cfg.is_none() && *expr < before && is_it(*receiver)).then_some(*receiver)
        };
        rest.iter().filter_map(emptied).next_back()
    }

    /// Whether a loop over the collection that a local is declared with may be left in one of its rounds, so that only their order tells
    /// which elements had one.
    pub(in crate::flow::lower) fn is_left_in_a_round(&self, value: ExprId) -> bool {
        let (tree, typed) = (self.body(), self.typed());
        tree.exprs.iter().any(|expr| {
            let (iterable, body) = match &expr.kind {
                ExprKind::For { iterable, body, .. } => (iterable, body),
                ExprKind::While { condition, body, .. } => (condition, body),
                _ => return false,
            };
            let is_left = tree.within(*body).any(|id| match &tree.expr(id).kind {
                ExprKind::Break { .. } | ExprKind::Return(_) | ExprKind::Try(_) => true,
                ExprKind::Continue { label } => label.is_some(),
                _ => false,
            });
            is_left
                && tree.within(*iterable).any(|id| {
                    let local = typed.expr_local.get(&id);
                    local.and_then(|local| self.declaration(*local)).is_some_and(|(init, _)| init == value)
                })
        })
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

    /// How many elements a value has that a collection is declared with, if that is written there.
    fn elements_of(&self, value: ExprId) -> Option<u64> {
        if let Ty::Array(_, length) = self.ty(value).peel() {
            return length.value;
        }
        match &self.body().expr(value).kind {
            ExprKind::Array { elements, .. } => Some(elements.len() as u64),
            ExprKind::MethodCall { receiver, method, args, .. } if args.is_empty() => {
                let keeps_all = matches!(
                    method.as_str(),
                    "into_iter" | "iter_mut" | "rev" | "collect" | "into" | "into_vec" | "to_vec" | "each_mut"
                );
                self.elements_of(*receiver).filter(|_| keeps_all)
            }
            ExprKind::Call { callee, args } => {
                let ExprKind::Path(path) = &self.body().expr(*callee).kind else { return None };
                match (path.last(), args.as_slice()) {
                    ("new", []) | ("with_capacity", [_]) => Some(0),
                    ("from", [given]) => self.elements_of(*given),
                    _ => None,
                }
            }
            _ => None,
        }
    }
}

/// Whether a collection puts its elements in an order of their own.
pub(in crate::flow::lower) fn is_heap(ty: &Ty) -> bool {
    ty.external_name() == Some("BinaryHeap")
}

/// What is done with a collection where it is named.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Use {
    /// Something is put behind its elements.
    Push,
    /// Nothing comes to it or leaves it, and its elements stay where they are.
    Look,
    /// Nothing leaves it.
    Order,
    Other,
}

fn use_of(body: &Body, named: ExprId) -> Use {
    let found = body.exprs.iter().find_map(|expr| match &expr.kind {
        ExprKind::MethodCall { receiver, method, .. } if *receiver == named => Some(match method.as_str() {
            "push" | "push_back" => Use::Push,
            "iter" | "iter_mut" | "len" | "is_empty" | "first" | "last" | "first_mut" | "last_mut" | "front_mut"
            | "back_mut" | "get_mut" => Use::Look,
            "push_front" | "extend" | "reverse" | "swap" | "rotate_left" | "rotate_right" | "as_mut_slice" => {
                Use::Order
            }
            _ => Use::Other,
        }),
        ExprKind::Index { base, .. } if *base == named => Some(Use::Look),
        ExprKind::For { iterable, .. } => {
            let is_lent = matches!(&body.expr(*iterable).kind, ExprKind::Reference { value, .. } if *value == named);
            is_lent.then_some(Use::Look)
        }
        _ => None,
    });
    found.unwrap_or(Use::Other)
}
