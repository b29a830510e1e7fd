//! Whether a variable is free to be updated where another one is: no reference that has a name holds it, no closure, no thread.

use super::site::Site;
use crate::index::Ty;
use crate::syntax::tree::{ExprId, ExprKind, StmtKind};
use crate::types::LocalId;

/// Whether all that uses the variable up to the end of the loops around a place gives it back at once.
pub(super) fn is_free(site: &Site<'_>, at: ExprId, local: LocalId) -> bool {
    let uses = Uses { site, parents: site.body.parents() };
    let closure = uses.closure(at);
    let is_loop =
        |id: &ExprId| matches!(uses.kind(*id), ExprKind::Loop { .. } | ExprKind::While { .. } | ExprKind::For { .. });
    let end = uses.ancestors(at).filter(is_loop).map(|id| site.body.expr(id).span.end).max();
    let is_later = |id: ExprId| end.is_some_and(|end| site.body.expr(id).span.start >= end);
    let mut all = site.typed.expr_local.iter().filter(|(_, own)| **own == local).map(|(id, _)| *id);
    all.all(|id| uses.closure(id) == closure && (is_later(id) || uses.is_brief(id)))
}

struct Uses<'a> {
    site: &'a Site<'a>,
    parents: Vec<Option<ExprId>>,
}

impl Uses<'_> {
    fn kind(&self, id: ExprId) -> &ExprKind {
        &self.site.body.expr(id).kind
    }

    fn ancestors(&self, id: ExprId) -> impl Iterator<Item = ExprId> + '_ {
        std::iter::successors(self.parents[id.0 as usize], |id| self.parents[id.0 as usize])
    }

    /// The closure that an expression lies in.
    fn closure(&self, id: ExprId) -> Option<ExprId> {
        self.ancestors(id).find(|at| matches!(self.kind(*at), ExprKind::Closure(_)))
    }

    /// Whether what uses a place holds nothing of it afterwards.
    fn is_brief(&self, id: ExprId) -> bool {
        let Some(parent) = self.parents[id.0 as usize] else { return false };
        match self.kind(parent) {
            ExprKind::Field { .. } | ExprKind::Index { .. } => {
                is_value(self.site.typed.ty(parent)) || self.is_brief(parent)
            }
            ExprKind::MethodCall { receiver, .. } if *receiver == id => self.gives_nothing_of_it(parent),
            ExprKind::Call { .. } | ExprKind::MethodCall { .. } if matches!(self.site.typed.ty(id), Ty::Ref(..)) => {
                self.gives_nothing_of_it(parent)
            }
            ExprKind::Reference { .. } => match self.parents[parent.0 as usize] {
                Some(call) => match self.kind(call) {
                    ExprKind::Call { .. } | ExprKind::MethodCall { .. } => self.gives_nothing_of_it(call),
                    ExprKind::Macro(_) => true,
                    _ => false,
                },
                None => false,
            },
            ExprKind::Assign { place, .. } => *place == id || is_value(self.site.typed.ty(id)),
            ExprKind::Macro(_) | ExprKind::Binary { .. } => true,
            _ => is_value(self.site.typed.ty(id)),
        }
    }

    /// Whether a call gives back nothing that may be borrowed, or nobody keeps it.
    fn gives_nothing_of_it(&self, call: ExprId) -> bool {
        let is_dropped = |parent: ExprId| match self.kind(parent) {
            ExprKind::Block(block) => {
                let is_it = |kind: &StmtKind| matches!(kind, StmtKind::Expr { expr, semicolon: true } if *expr == call);
                block.stmts.iter().any(|stmt| is_it(&stmt.kind))
            }
            ExprKind::Macro(_) => true,
            _ => false,
        };
        is_value(self.site.typed.ty(call)) || self.parents[call.0 as usize].is_some_and(is_dropped)
    }
}

/// Whether a type is a plain value, which borrows nothing.
fn is_value(ty: &Ty) -> bool {
    match ty {
        Ty::Int | Ty::Float | Ty::Bool | Ty::Char | Ty::Never => true,
        Ty::Tuple(parts) => parts.iter().all(is_value),
        _ => false,
    }
}
