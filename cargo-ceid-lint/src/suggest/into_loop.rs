//! A guard that is made before the loop, moved to the head of the loop's body.

use std::ops::Range;

use super::loans::{needs, place};
use super::site::{Site, bytes};
use super::words::{
    OwnLines, has_comment, has_word, indentation, line_break, line_of, mentions, own_lines, with_blank_line,
};
use crate::diagnostic::{Applicability, Suggestion};
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, PatId, PatKind, Stmt, StmtKind};

/// The statement that makes the guard, and the one before it that asks for the cycle's token, moved into the loop at `keyword`.
///
/// What they need stays in reach, and nothing outside of the loop's body uses what they declare.
///
/// A guard that each round of another loop makes stays: that the inner one is meant, its rounds do not tell for sure.
pub(super) fn suggestion(site: &Site<'_>, keyword: Span) -> Option<Suggestion> {
    let guard = site.stmt().span;
    let is_around = |body: ExprId| site.body.expr(body).span.contains(guard);
    let is_of_round = site.body.exprs.iter().any(|expr| match expr.kind {
        ExprKind::Loop { body, .. } | ExprKind::While { body, .. } | ExprKind::For { body, .. } => is_around(body),
        _ => false,
    });
    if is_of_round {
        return None;
    }
    let mut moved = vec![site.at];
    let (names, init) = declared(site, site.stmt())?;
    let needs = needs(site, init)?;
    let mut names: Vec<String> = names;
    let mut reached: Vec<String> = needs.loans.iter().map(|loan| loan.root.clone()).collect();
    if let Some(token) = &needs.token {
        let (at, source) = asked_for(site, token)?;
        moved.insert(0, at);
        names.push(token.clone());
        reached.push(source);
    }
    let (whole, body) = the_loop(site, keyword)?;
    let first = bytes(site.block.stmts[moved[0]].span).start;
    // Between the guard and the loop, in the loop's head and behind the loop.
    let mut outside = vec![bytes(whole).start..bytes(body).start, bytes(whole).end..site.braces.end];
    for (at, stmt) in site.block.stmts.iter().enumerate() {
        let own = bytes(stmt.span);
        if own.start > first && own.end <= bytes(whole).start && !moved.contains(&at) {
            outside.push(own);
        }
    }
    // A filter that is lent under its own name is found there by whatever follows a dot.
    let is_own = |name: &String| needs.loans.iter().any(|loan| loan.field.is_none() && loan.root == *name);
    let is_mentioned = |name: &String| {
        let mut found = outside.iter().flat_map(|range| mentions(site.text, range.clone(), name));
        found.any(|mention| mention.member.is_none() || !is_own(name))
    };
    let is_hidden = |local: &crate::types::Local| {
        let at = local.span.start as usize;
        reached.contains(&local.name) && outside.iter().any(|range| range.contains(&at))
    };
    if names.iter().any(is_mentioned) || site.typed.locals.iter().any(is_hidden) {
        return None;
    }
    let own: Vec<Range<usize>> = moved.iter().map(|at| own(site, &site.block.stmts[*at])).collect::<Option<_>>()?;
    let mut edits: Vec<(Range<usize>, String)> =
        joined(&own).into_iter().map(|lines| (with_blank_line(site.text, lines), String::new())).collect();
    edits.push(inserted(site, bytes(whole).start, bytes(body), &own)?);
    let message = "make the guard in each round of the loop".to_owned();
    Some(site.suggestion(message, edits, Applicability::MachineApplicable))
}

/// The names that a statement declares, and the expression that it takes them from.
fn declared(site: &Site<'_>, stmt: &Stmt) -> Option<(Vec<String>, ExprId)> {
    match &stmt.kind {
        StmtKind::Let { pat, init: Some(init), otherwise, .. } => {
            let otherwise = otherwise.map(|id| bytes(site.body.expr(id).span));
            // In a loop, these words would mean that loop.
            let leaves = |word| otherwise.as_ref().is_some_and(|range| has_word(site.text, range.clone(), word));
            (!leaves("break") && !leaves("continue")).then_some((vec![bound(site, *pat)?], *init))
        }
        StmtKind::Expr { expr, .. } => match &site.body.expr(*expr).kind {
            ExprKind::Macro(own) => match &own.kind {
                crate::syntax::tree::MacroKind::Ceid { filters, .. } => {
                    Some((filters.iter().map(|(name, _)| name.clone()).collect(), *expr))
                }
                _ => None,
            },
            _ => None,
        },
        StmtKind::Let { .. } => None,
    }
}

/// The name that a pattern binds, alone or in `Some`.
fn bound(site: &Site<'_>, pat: PatId) -> Option<String> {
    match &site.body.pat(pat).kind {
        PatKind::Bind { name, by_ref: false, sub: None, .. } => Some(name.clone()),
        PatKind::TupleStruct(_, parts) => match parts.as_slice() {
            [one] => bound(site, *one),
            _ => None,
        },
        _ => None,
    }
}

/// The statement before the guard that asks a clock for the token, and the variable that holds the clock.
fn asked_for(site: &Site<'_>, token: &str) -> Option<(usize, String)> {
    let before = &site.block.stmts[..site.at];
    let (at, stmt) = before
        .iter()
        .enumerate()
        .rev()
        .find(|(_, stmt)| declared(site, stmt).is_some_and(|(names, _)| names == [token]) && site.is_plain(stmt))?;
    let (_, mut init) = declared(site, stmt)?;
    loop {
        match &site.body.expr(init).kind {
            ExprKind::MethodCall { receiver, method, args, .. } => match method.as_str() {
                "next_cycle" | "begin_cycle" if args.is_empty() => return Some((at, place(site, *receiver)?.root)),
                "unwrap" | "expect" => init = *receiver,
                _ => return None,
            },
            ExprKind::Try(inner) => init = *inner,
            _ => return None,
        }
    }
}

/// The loop with that keyword, if it stands in the block of the guard: the whole of it, and its body.
fn the_loop(site: &Site<'_>, keyword: Span) -> Option<(Span, Span)> {
    let stmts =
        site.block.stmts[site.at + 1..].iter().filter(|stmt| site.is_plain(stmt)).filter_map(|stmt| match stmt.kind {
            StmtKind::Expr { expr, .. } => Some((expr, stmt.span)),
            StmtKind::Let { .. } => None,
        });
    let tail = site.block.tail.map(|tail| (tail, site.body.expr(tail).span));
    stmts.chain(tail).find_map(|(expr, span)| match &site.body.expr(expr).kind {
        ExprKind::Loop { keyword: own, body, .. }
        | ExprKind::While { keyword: own, body, .. }
        | ExprKind::For { keyword: own, body, .. }
            if *own == keyword =>
        {
            let body = site.body.expr(*body).span;
            site.snippet(body).starts_with('{').then_some((span, body))
        }
        _ => None,
    })
}

/// The lines of a statement with what goes with it: the comments on lines of their own directly above, and the one behind it.
fn own(site: &Site<'_>, stmt: &Stmt) -> Option<Range<usize>> {
    let OwnLines { mut lines, .. } = own_lines(site.text, bytes(stmt.span))?;
    // What stands on several lines in a string or a comment cannot be indented anew.
    let inside = site.snippet(stmt.span);
    if inside.contains('\n') && (inside.contains('"') || has_comment(site.text, bytes(stmt.span))) {
        return None;
    }
    while let Some(end) = lines.start.checked_sub(1) {
        let above = line_of(site.text, end);
        let line = site.text[above.clone()].trim();
        // A comment on several lines begins with a line of its own.
        let opening = match line.strip_suffix("*/") {
            Some(_) => site.text[..above.end].rfind("/*").map(|open| line_of(site.text, open)),
            None => Some(above).filter(|_| line.starts_with("//")),
        };
        let Some(first) = opening.filter(|first| site.text[first.clone()].trim_start().starts_with('/')) else { break };
        lines.start = first.start;
    }
    Some(lines)
}

/// The lines, those that follow each other taken together.
fn joined(own: &[Range<usize>]) -> Vec<Range<usize>> {
    let mut joined: Vec<Range<usize>> = Vec::new();
    for lines in own {
        match joined.last_mut().filter(|last| last.end == lines.start) {
            Some(last) => last.end = lines.end,
            None => joined.push(lines.clone()),
        }
    }
    joined
}

/// The moved lines at the head of a loop's body, indented as the body is.
fn inserted(site: &Site<'_>, head: usize, body: Range<usize>, own: &[Range<usize>]) -> Option<(Range<usize>, String)> {
    let text = site.text;
    let opening = line_of(text, body.start);
    let behind = text.get(body.start + 1..opening.end).unwrap_or_default().trim();
    if opening.end >= body.end || !(behind.is_empty() || behind.starts_with("//")) {
        // The body stands on the line of its brace.
        return None;
    }
    let line_break = line_break(text, body.start);
    let at = opening.end + line_break.len();
    let first = text[at..body.end].lines().map(str::trim_end).find(|line| !line.trim().is_empty())?;
    let outer = indentation(text, head);
    let indent = if first.trim_start().starts_with('}') {
        format!("{outer}{}", if outer.contains('\t') { "\t" } else { "    " })
    } else {
        first[..first.len() - first.trim_start().len()].to_owned()
    };
    let mut lines = String::new();
    for line in own.iter().flat_map(|lines| text[lines.clone()].lines()) {
        let line = line.trim_end_matches('\r');
        lines += &indent;
        lines += line.strip_prefix(outer).unwrap_or_else(|| line.trim_start());
        lines += line_break;
    }
    Some((at..at, lines))
}
