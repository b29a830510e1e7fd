//! The value at the end of a block: before edition 2024 what it borrows on the way lives longer than the variables of the block, and
//! so longer than a guard.

use super::Reason;
use super::body::LoopBody;
use super::hollow::{Cut, cuts};
use super::locks::lock_behind;
use super::mentions::{Guarded, is_about};
use super::owned::is_owned;
use super::purity::acts_when_dropped;
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{BlockKind, ExprId, ExprKind, MacroKind, Stmt, StmtKind};

/// What the end of the iteration borrows of a guarded place until after what it borrows from is gone: its guard goes before.
pub(super) fn outlives_owner(of: &LoopBody<'_>, guarded: &[Guarded], edition: &str) -> Option<Reason> {
    if !gives_back_late(edition) || semicolon(of, guarded, edition).is_some() {
        return None;
    }
    let (last, _) = last(of, guarded, &cuts(of, guarded))?;
    let loans = loans(of, last);
    let of_guarded =
        |own: &Guarded| Some((first_naming(of, &loans, |id| is_about(of, &own.place, id))?, own.spelled.clone()));
    let (at, name) = guarded.iter().find_map(of_guarded)?;
    let text = format!(
        "before edition 2024, what is borrowed of `{name}` at the end of a block is given back after the variables of the block, and so \
         after the guard of `{name}`: put `;` behind it, or give its value a name with `let` first"
    );
    Some(Reason { span: of.span(at), text })
}

/// The `;` behind an expression at the end of the iteration that an update stands behind today, so that what it borrows is given back
/// where it is today, and not after the variables of the block.
pub(super) fn semicolon(of: &LoopBody<'_>, guarded: &[Guarded], edition: &str) -> Option<(Span, String)> {
    if !gives_back_late(edition) {
        return None;
    }
    let cuts = cuts(of, guarded);
    let (last, is_tail) = last(of, guarded, &cuts)?;
    let end = of.span(last).end;
    let has_one = cuts.iter().any(|cut| cut.range.end == end as usize && cut.instead.ends_with(';'));
    let is_needed = !is_tail && is_shown_by_update(of, guarded, last) && !loans(of, last).is_empty();
    (is_needed && !has_one).then(|| (Span { start: end, ..of.span(last) }, ";".to_owned()))
}

/// Whether the end of a block gives back what it borrows after the variables of the block are gone.
fn gives_back_late(edition: &str) -> bool {
    matches!(edition, "2018" | "2021")
}

/// Whether an expression stands at the end of the iteration only once an update behind it is gone.
fn is_shown_by_update(of: &LoopBody<'_>, guarded: &[Guarded], last: ExprId) -> bool {
    let stmts = guarded.iter().flat_map(|own| &own.sites).filter_map(|site| site.stmt.as_ref());
    let end = of.span(last).end as usize;
    stmts.into_iter().any(|stmt| stmt.start >= end)
}

fn first_naming(of: &LoopBody<'_>, loans: &[ExprId], names: impl Fn(ExprId) -> bool) -> Option<ExprId> {
    loans.iter().copied().find(|id| of.body.within(*id).any(&names))
}

/// What an expression may borrow until it has its value, and give back only then.
fn loans(of: &LoopBody<'_>, id: ExprId) -> Vec<ExprId> {
    let mut temporaries = Vec::new();
    collect(of, id, &mut temporaries);
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
    temporaries.retain(lends);
    temporaries
}

/// What becomes of `let y = kf.y; kf.update(); y`, so that the value has no name that nothing needs any more: what is written instead
/// of the beginning of the statement, and what goes from its value to the end.
pub(super) fn without_name(of: &LoopBody<'_>, guarded: &[Guarded], edition: &str) -> Option<(Span, Span)> {
    let ExprKind::Block(block) = of.kind(of.block) else { return None };
    let tail = block.tail?;
    let local = of.typed.expr_local.get(&tail)?;
    let stmts: Vec<_> = guarded.iter().flat_map(|own| &own.sites).filter_map(|site| site.stmt.as_ref()).collect();
    let is_gone = |stmt: &&Stmt| stmts.iter().any(|gone| gone.contains(&(stmt.span.start as usize)));
    let bound = block.stmts.iter().rev().find(|stmt| !is_gone(stmt))?;
    let StmtKind::Let { pat, ty: None, init: Some(init), otherwise: None } = &bound.kind else { return None };
    let is_it = of.typed.pat_local.get(pat) == Some(local) && of.names(*local).count() == 1;
    let mut between = of.text.get(bound.span.end as usize..of.span(tail).start as usize)?.to_owned();
    for gone in stmts.iter().filter(|gone| gone.start >= bound.span.end as usize) {
        between = between.replace(of.text.get((*gone).clone())?, "");
    }
    let scope = of.program.index.scope_of(of.function);
    let is_plain = is_owned(of.program.index, &scope, of.typed.ty(*init))
        && (!gives_back_late(edition) || loans(of, *init).is_empty());
    let is_alone = bound.cfg.is_none() && between.trim().is_empty();
    let had_update = stmts.iter().any(|gone| gone.start >= bound.span.end as usize);
    let head = Span { end: of.span(*init).start, ..bound.span };
    let rest = Span { start: of.span(*init).end, ..of.span(tail) };
    (is_it && is_plain && is_alone && had_update).then_some((head, rest))
}

/// The expression at the end of the iteration once the updates and what is hollow without them are gone, and whether it is its value.
fn last(of: &LoopBody<'_>, guarded: &[Guarded], cuts: &[Cut]) -> Option<(ExprId, bool)> {
    let ExprKind::Block(block) = of.kind(of.block) else { return None };
    let whole = guarded.iter().flat_map(|own| &own.sites).filter(|site| site.emptied.is_none());
    let cut = cuts.iter().filter(|cut| cut.is_statement).map(|cut| &cut.range);
    let gone: Vec<_> = whole.filter_map(|site| site.stmt.as_ref()).chain(cut).collect();
    let is_gone = |span: Span| gone.iter().any(|range| range.contains(&(span.start as usize)));
    if let Some(tail) = block.tail.filter(|tail| !is_gone(of.span(*tail))) {
        return Some((tail, true));
    }
    let last = block.stmts.iter().rev().find(|stmt| !is_gone(stmt.span))?;
    match last.kind {
        // A block needs no semicolon to be a statement.
        StmtKind::Expr { expr, semicolon: false } => Some((expr, false)),
        _ => None,
    }
}

/// What is made on the way to the value of an expression and lives as long as that.
fn collect(of: &LoopBody<'_>, id: ExprId, found: &mut Vec<ExprId>) {
    match of.kind(id) {
        ExprKind::If { condition, .. } => scrutinees(of, *condition, found),
        ExprKind::Match { scrutinee, .. } => collect(of, *scrutinee, found),
        ExprKind::Block(block) if block.kind != BlockKind::Async => {
            if let Some(tail) = block.tail {
                collect(of, tail, found);
            }
        }
        // What the head of a loop borrows is given back where the loop ends.
        ExprKind::Loop { .. } | ExprKind::While { .. } | ExprKind::For { .. } => {}
        ExprKind::Block(_) | ExprKind::Closure(_) => {}
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

/// What `if let` looks into.
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
