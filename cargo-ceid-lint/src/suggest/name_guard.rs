//! `let _ = cycle.guard(…)` and a guard that is no more than a statement: it gets a name, and lives to the end of its block.

use std::ops::Range;

use super::loans::{Needs, needs};
use super::site::{Site, bytes};
use super::words::{has_word, indentation, line_break, mentions, own_lines};
use crate::diagnostic::{Applicability, Suggestion};
use crate::syntax::tree::{ExprId, PatKind, StmtKind};

/// Names for a guard that nothing reads.
const UNREAD: &[&str] = &["_guard", "_cycle_guard", "_guard_of_cycle"];

/// Names for a guard whose filters are read.
const READ: &[&str] = &["guard", "cycle_guard", "guard_of_cycle"];

/// The statement with a name for its guard, if what follows can live with the guard.
pub(super) fn suggestion(site: &Site<'_>) -> Option<Suggestion> {
    let (head, init) = unbound(site)?;
    let needs = needs(site, init)?;
    let rest = bytes(site.stmt().span).end..site.braces.end;
    if !conflicts(site, &needs, rest.clone(), None) {
        let text = format!("let {} = ", site.free_name(UNREAD)?);
        let message = "give the guard a name".to_owned();
        return Some(site.suggestion(message, vec![(head, text)], Applicability::MachineApplicable));
    }
    let filter = needs.filter.as_deref()?;
    // What `filters` gives is a reference: whatever follows a dot finds it, and nothing else does.
    if has_word(site.text, rest.clone(), "move") || conflicts(site, &needs, rest, Some(filter)) {
        return None;
    }
    let guard = site.free_name(READ)?;
    let end = bytes(site.stmt().span).end;
    let own = own_lines(site.text, bytes(site.stmt().span));
    let (at, next) = match &own {
        Some(own) => (
            own.comment.as_ref().map_or(end, |comment| comment.end),
            format!("{}{}", line_break(site.text, end), indentation(site.text, head.start)),
        ),
        None => (end, " ".to_owned()),
    };
    let edits =
        vec![(head, format!("let mut {guard} = ")), (at..at, format!("{next}let {filter} = {guard}.filters();"))];
    let message = format!("give the guard a name, and reach `{filter}` through it");
    Some(site.suggestion(message, edits, Applicability::MachineApplicable))
}

/// What stands before the expression that makes the guard, and the expression.
fn unbound(site: &Site<'_>) -> Option<(Range<usize>, ExprId)> {
    let stmt = site.stmt();
    let start = stmt.span.start as usize;
    match &stmt.kind {
        StmtKind::Let { pat, ty: None, init: Some(init), otherwise: None } => {
            let value = bytes(site.body.expr(*init).span);
            let is_wild = matches!(site.body.pat(*pat).kind, PatKind::Wild);
            let is_short = site.text.get(start..value.start)?.split_whitespace().eq(["let", "_", "="]);
            (is_wild && is_short && site.place == stmt.span).then_some((start..value.start, *init))
        }
        StmtKind::Expr { expr, semicolon: true } if site.place == stmt.span => Some((start..start, *expr)),
        _ => None,
    }
}

/// Whether what follows uses what the guard borrows: the `lent` variable in other ways than behind a dot, anything else at all.
fn conflicts(site: &Site<'_>, needs: &Needs, rest: Range<usize>, lent: Option<&str>) -> bool {
    needs.loans.iter().any(|loan| {
        mentions(site.text, rest.clone(), &loan.root).iter().any(|mention| match (&loan.field, mention.member) {
            (None, member) => lent != Some(&loan.root) || member.is_none(),
            (Some(field), Some(member)) => mention.is_called || member == field,
            (Some(_), None) => true,
        })
    })
}
