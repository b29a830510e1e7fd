//! The value at the end of a block: before edition 2024 what it borrows on the way lives longer than the variables of the block, and
//! so longer than a guard.

use super::Reason;
use super::body::LoopBody;
use super::locks::lock_behind;
use super::mentions::{Guarded, is_about};
use super::owned::is_owned;
use super::purity::acts_when_dropped;
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{BlockKind, ExprId, ExprKind, MacroKind, StmtKind};

/// What the end of the iteration borrows from a guarded place until after its guard is gone.
pub(super) fn outlives_guard(of: &LoopBody<'_>, guarded: &[Guarded], edition: &str) -> Option<Reason> {
    if !matches!(edition, "2018" | "2021") {
        return None;
    }
    let mut temporaries = Vec::new();
    collect(of, last(of, guarded)?, &mut temporaries);
    let index = of.program.index;
    let scope = index.scope_of(of.function);
    let lends = |id: &ExprId| {
        if let ExprKind::MethodCall { receiver, method, .. } = of.kind(*id)
            && matches!(method.as_str(), "borrow" | "borrow_mut" | "lock" | "read" | "write")
            && lock_behind(of.typed.ty(*receiver)).is_some()
        {
            return true;
        }
        let ty = of.typed.ty(*id);
        let is_unknown = matches!(ty, Ty::Unknown | Ty::Var(_) | Ty::Opaque(_) | Ty::Param(_));
        (is_unknown || acts_when_dropped(index, ty)) && !is_owned(index, &scope, ty)
    };
    let names = |id: &ExprId, own: &Guarded| of.body.within(*id).into_iter().any(|at| is_about(of, &own.place, at));
    let (at, own) = temporaries
        .into_iter()
        .filter(lends)
        .find_map(|id| guarded.iter().find(|own| names(&id, own)).map(|own| (id, own)))?;
    let text = format!(
        "before edition 2024, what is borrowed of `{}` at the end of a block is given back after the variables of the block, and so \
         after its guard: put `;` behind it, or give its value a name with `let` first",
        own.spelled
    );
    Some(Reason { span: of.span(at), text })
}

/// The expression at the end of the iteration once the updates are gone.
pub(super) fn last(of: &LoopBody<'_>, guarded: &[Guarded]) -> Option<ExprId> {
    let ExprKind::Block(block) = of.kind(of.block) else { return None };
    let gone: Vec<_> = guarded.iter().flat_map(|own| &own.sites).filter(|site| site.emptied.is_none()).collect();
    let is_gone = |span: Span| {
        let is_in = |stmt: &std::ops::Range<usize>| stmt.contains(&(span.start as usize));
        gone.iter().filter_map(|site| site.stmt.as_ref()).any(is_in)
    };
    if let Some(tail) = block.tail.filter(|tail| !is_gone(of.span(*tail))) {
        return Some(tail);
    }
    let last = block.stmts.iter().rev().find(|stmt| !is_gone(stmt.span))?;
    match last.kind {
        // A block needs no semicolon to be a statement.
        StmtKind::Expr { expr, semicolon: false } => Some(expr),
        _ => None,
    }
}

/// What is made on the way to the value of an expression and lives as long as that.
fn collect(of: &LoopBody<'_>, id: ExprId, found: &mut Vec<ExprId>) {
    match of.kind(id) {
        ExprKind::If { condition, .. } | ExprKind::While { condition, .. } => scrutinees(of, *condition, found),
        ExprKind::Match { scrutinee, .. } => collect(of, *scrutinee, found),
        ExprKind::For { iterable, .. } => collect(of, *iterable, found),
        ExprKind::Block(block) if block.kind != BlockKind::Async => {
            if let Some(tail) = block.tail {
                collect(of, tail, found);
            }
        }
        ExprKind::Block(_) | ExprKind::Loop { .. } | ExprKind::Closure(_) => {}
        ExprKind::Binary { op: "&&" | "||", lhs, .. } => collect(of, *lhs, found),
        // Most macros make statements of what they are given.
        ExprKind::Macro(call) if !matches!(call.kind, MacroKind::AssertCompare(..)) => {}
        ExprKind::Path(_) | ExprKind::Literal(_) => {}
        ExprKind::Field { base, .. } | ExprKind::Index { base, .. } => collect(of, *base, found),
        _ => {
            found.push(id);
            for child in of.body.children(id) {
                collect(of, child, found);
            }
        }
    }
}

/// What `if let` and `while let` look into.
fn scrutinees(of: &LoopBody<'_>, condition: ExprId, found: &mut Vec<ExprId>) {
    match of.kind(condition) {
        ExprKind::Let { value, .. } => collect(of, *value, found),
        ExprKind::Binary { op: "&&", lhs, rhs } => {
            scrutinees(of, *lhs, found);
            scrutinees(of, *rhs, found);
        }
        _ => {}
    }
}
