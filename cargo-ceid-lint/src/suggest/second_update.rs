//! The second of two updates in a row, removed.

use super::site::{Site, bytes};
use super::words::{has_comment, mentions, own_lines, with_blank_line};
use crate::count::Pair;
use crate::diagnostic::{Applicability, Suggestion};
use crate::syntax::tree::{ExprId, ExprKind, Stmt, StmtKind};

/// The statement of the second update removed: with its lines, if it has them for itself, and the comment behind it.
///
/// The first update is a statement of the same block, so that no path passes the second one alone. What its arguments do would be
/// lost, so they do nothing.
pub(super) fn suggestion(site: &Site<'_>, pair: &Pair) -> Option<Suggestion> {
    let second = site.stmt();
    let call = update(site, second, pair)?;
    let is_first = |stmt: &&Stmt| update(site, stmt, pair).is_some_and(|first| same_target(site, first, call));
    // Whether a statement is plain takes longer to find out.
    let first = site.block.stmts[..site.at].iter().rev().filter(is_first).find(|stmt| site.is_plain(stmt))?;
    let StmtKind::Expr { expr: first, .. } = first.kind else { return None };
    let ExprKind::MethodCall { args, .. } = &site.body.expr(call).kind else { return None };
    let is_same = site.spelled(first) == site.spelled(call);
    if !args.iter().all(|arg| is_pure(site, *arg, is_same)) {
        return None;
    }
    let own = bytes(second.span);
    if has_comment(site.text, own.clone()) {
        return None;
    }
    let Some(lines) = own_lines(site.text, own.clone()) else {
        let before = site.text[..own.start].trim_end_matches([' ', '\t']).len();
        let message = "remove this update".to_owned();
        return Some(site.suggestion(message, vec![(before..own.end, String::new())], Applicability::MaybeIncorrect));
    };
    let behind = if lines.comment.is_some() { ", and the comment behind it" } else { "" };
    let removed = with_blank_line(site.text, lines.lines);
    let message = format!("remove this update{behind}");
    Some(site.suggestion(message, vec![(removed, String::new())], Applicability::MaybeIncorrect))
}

/// The call of the law that a statement is, if its value goes nowhere.
fn update(site: &Site<'_>, stmt: &Stmt, pair: &Pair) -> Option<ExprId> {
    let StmtKind::Expr { expr, semicolon: true } = stmt.kind else { return None };
    let call = site.body.expr(expr);
    let ExprKind::MethodCall { receiver, .. } = &call.kind else { return None };
    let is_law = pair.through.is_empty() && pair.updates.contains(&call.span);
    (is_law && site.spelled(*receiver) == pair.name).then_some(expr)
}

fn same_target(site: &Site<'_>, one: ExprId, other: ExprId) -> bool {
    match (&site.body.expr(one).kind, &site.body.expr(other).kind) {
        (
            ExprKind::MethodCall { receiver: one, method: one_method, .. },
            ExprKind::MethodCall { receiver: other, method: other_method, .. },
        ) => one_method == other_method && site.spelled(*one) == site.spelled(*other),
        _ => false,
    }
}

/// Whether nothing is lost with an argument: it does nothing, and every variable in it is used elsewhere, as it is by an earlier
/// statement that `is_same`.
fn is_pure(site: &Site<'_>, id: ExprId, is_same: bool) -> bool {
    let all = |parts: &[ExprId]| parts.iter().all(|part| is_pure(site, *part, is_same));
    match &site.body.expr(id).kind {
        ExprKind::Literal(_) => true,
        ExprKind::Path(_) => match site.typed.expr_local.get(&id) {
            Some(local) => is_same || is_used_elsewhere(site, &site.typed.local(*local).name),
            None => true,
        },
        ExprKind::Reference { mutable, raw: false, value } => (is_same || !mutable) && all(&[*value]),
        ExprKind::Field { base: value, .. }
        | ExprKind::Deref(value)
        | ExprKind::Not(value)
        | ExprKind::Negate(value)
        | ExprKind::Cast { value, .. } => all(&[*value]),
        ExprKind::Index { base: lhs, index: rhs } | ExprKind::Binary { lhs, rhs, .. } => all(&[*lhs, *rhs]),
        ExprKind::Tuple(parts) | ExprKind::Array { elements: parts, .. } => all(parts),
        _ => false,
    }
}

/// Whether a variable is used by more than the statement that goes: beside that, its declaration mentions it, and a use does.
fn is_used_elsewhere(site: &Site<'_>, name: &str) -> bool {
    let own = bytes(site.stmt().span);
    let outside = [site.function.start..own.start, own.end..site.function.end];
    let count: usize = outside.into_iter().map(|range| mentions(site.text, range, name).len()).sum();
    name == "self" || count > 1
}
