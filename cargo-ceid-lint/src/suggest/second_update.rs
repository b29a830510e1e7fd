//! The second of two updates in a row, removed.

use std::ops::Range;

use super::site::{Site, bytes};
use super::words::{has_comment, mentions, own_lines, with_blank_line};
use crate::count::Pair;
use crate::diagnostic::{Applicability, Suggestion};
use crate::source::Span;
use crate::syntax::tree::{Block, ExprId, ExprKind, PatKind, Stmt, StmtKind};

/// The statement of the second update removed: with its lines, if it has them for itself, and the comment behind it.
///
/// The first update is a statement of the same block, so that no path passes the second one alone. What its arguments do would be
/// lost, so they do nothing.
pub(super) fn suggestion(site: &Site<'_>, pair: &Pair) -> Option<Suggestion> {
    let second = site.stmt();
    let call = update(site, second, pair)?;
    let is_first = |stmt: &&Stmt| update(site, stmt, pair).is_some_and(|first| same_target(site, first, call));
    // Whether a statement is plain takes longer to find out.
    let mut before = site.block.stmts[..site.at].iter().rev().chain(outer_before(site));
    let first = before.find(|stmt| is_first(stmt) && site.is_plain(stmt))?;
    let first = update(site, first, pair)?;
    let ExprKind::MethodCall { args, .. } = &site.body.expr(call).kind else { return None };
    let is_same = site.spelled(first) == site.spelled(call);
    let own = match emptied(site) {
        None => bytes(second.span),
        Some(branch) => bytes(branch?),
    };
    if !args.iter().all(|arg| is_pure(site, *arg, is_same, &own)) {
        return None;
    }
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
    let expr = match &stmt.kind {
        StmtKind::Expr { expr, semicolon: true } => *expr,
        StmtKind::Let { pat, init: Some(init), otherwise: None, .. }
            if matches!(site.body.pat(*pat).kind, PatKind::Wild) =>
        {
            *init
        }
        _ => return None,
    };
    let call = site.body.expr(expr);
    let ExprKind::MethodCall { receiver, method, .. } = &call.kind else { return None };
    // A macro of which this is the last call would have no use any more.
    if !site.spelled(expr).contains(&format!(".{method}")) {
        return None;
    }
    let is_law = pair.through.is_empty() && pair.updates.contains(&call.span);
    (is_law && site.spelled(*receiver) == pair.name).then_some(expr)
}

/// The statements before those around the update: without another way past them, they ran before it.
fn outer_before<'a>(site: &Site<'a>) -> impl Iterator<Item = &'a Stmt> {
    let place = site.stmt().span;
    let blocks = site.body.exprs.iter().filter_map(move |expr| match &expr.kind {
        ExprKind::Block(block) if expr.span.contains(place) && expr.span != site.span(site.braces.clone()) => {
            Some(block)
        }
        _ => None,
    });
    let before = move |block: &'a Block| {
        let at = block.stmts.iter().position(|stmt| stmt.span.contains(place)).unwrap_or(block.stmts.len());
        block.stmts[..at].iter().rev()
    };
    blocks.flat_map(before)
}

/// The `if` that would do nothing without the update, if there is one; `Some(None)` where it cannot be taken away.
fn emptied(site: &Site<'_>) -> Option<Option<Span>> {
    let block = site.block;
    let is_branch = |kind: &ExprKind| match kind {
        ExprKind::If { then, otherwise, .. } => {
            [Some(*then), *otherwise].into_iter().flatten().any(|id| bytes(site.body.expr(id).span) == site.braces)
        }
        ExprKind::Loop { body, .. } | ExprKind::While { body, .. } | ExprKind::For { body, .. } => {
            bytes(site.body.expr(*body).span) == site.braces
        }
        ExprKind::Match { arms, .. } => arms.iter().any(|arm| bytes(site.body.expr(arm.body).span) == site.braces),
        _ => false,
    };
    let around = site.body.exprs.iter().find(|expr| is_branch(&expr.kind))?;
    if block.stmts.len() + usize::from(block.tail.is_some()) > 1 || !block.items.is_empty() {
        return None;
    }
    let ExprKind::If { condition, otherwise: None, .. } = &around.kind else { return Some(None) };
    let is_stmt =
        |stmt: &Stmt| matches!(stmt.kind, StmtKind::Expr { expr, .. } if site.body.expr(expr).span == around.span);
    let is_statement = site.body.exprs.iter().any(|expr| match &expr.kind {
        ExprKind::Block(block) => {
            block.stmts.iter().any(is_stmt) || block.tail.is_some_and(|tail| site.body.expr(tail).span == around.span)
        }
        _ => false,
    });
    Some((is_statement && is_pure(site, *condition, false, &bytes(around.span))).then_some(around.span))
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
fn is_pure(site: &Site<'_>, id: ExprId, is_same: bool, gone: &Range<usize>) -> bool {
    let all = |parts: &[ExprId]| parts.iter().all(|part| is_pure(site, *part, is_same, gone));
    match &site.body.expr(id).kind {
        ExprKind::Literal(_) => true,
        ExprKind::Path(_) => match site.typed.expr_local.get(&id) {
            Some(local) => is_same || is_used_elsewhere(site, &site.typed.local(*local).name, gone),
            None => true,
        },
        ExprKind::Reference { mutable, raw: false, value } => (is_same || !mutable) && all(&[*value]),
        ExprKind::Field { base: value, .. }
        | ExprKind::Deref(value)
        | ExprKind::Not(value)
        | ExprKind::Negate(value)
        | ExprKind::Cast { value, .. } => all(&[*value]),
        ExprKind::Index { base: lhs, index: rhs } | ExprKind::Binary { lhs, rhs, .. } => all(&[*lhs, *rhs]),
        ExprKind::Call { callee, args } if is_conversion(site.snippet(site.body.expr(*callee).span)) => all(args),
        ExprKind::Tuple(parts) | ExprKind::Array { elements: parts, .. } => all(parts),
        _ => false,
    }
}

/// Whether a function makes one number of another one.
fn is_conversion(function: &str) -> bool {
    let number = ["f32", "f64", "i8", "i16", "i32", "i64", "isize", "u8", "u16", "u32", "u64", "usize"];
    function.strip_suffix("::from").is_some_and(|ty| number.contains(&ty))
}

/// Whether a variable is used by more than the statement that goes: beside that, its declaration mentions it, and a use does.
fn is_used_elsewhere(site: &Site<'_>, name: &str, own: &Range<usize>) -> bool {
    let outside = [site.function.start..own.start, own.end..site.function.end];
    let count: usize = outside.into_iter().map(|range| mentions(site.text, range, name).len()).sum();
    name == "self" || count > 1
}
