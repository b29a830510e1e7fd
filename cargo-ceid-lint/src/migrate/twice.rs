//! Parts of a filter that are used at the same time. What lends a filter to its guard lends all of it, where a variable lends each field
//! by itself, and waits with a method's receiver until its arguments are there.

use super::Reason;
use super::body::LoopBody;
use super::each::{Reached, elements};
use super::mentions::{Guarded, Mention};
use super::owned::is_owned;
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, PatId, Receiver, StmtKind};
use crate::types::Callee;

/// How a filter is used at one place.
struct Use {
    /// The filter there.
    at: ExprId,
    /// Whether it may be changed.
    is_exclusive: bool,
    /// What is evaluated while it is lent for that.
    operands: Vec<ExprId>,
    /// How far what is made of it may still hold a part of it.
    held: Option<Span>,
}

/// Where a lent filter would be lent once more while it is.
pub(super) fn used_twice(of: &LoopBody<'_>, own: &Guarded, mentions: &[Mention]) -> Option<Reason> {
    let adaptation = own.adaptation.as_ref()?;
    let mut groups: Vec<Vec<ExprId>> = vec![Vec::new()];
    for mention in mentions {
        if adaptation.law.each.is_none() {
            groups[0].push(mention.at);
            continue;
        }
        match elements(of, mention.at) {
            Reached::One(element) => groups[0].push(element),
            Reached::Each(names) => groups.push(names),
            Reached::Nothing => groups[0].push(mention.at),
        }
    }
    // What feeds the filter is a method of what lends it.
    let is_fed = |at: &ExprId| own.sites.iter().any(|site| of.parent(*at) == Some(site.call));
    groups.iter_mut().for_each(|group| group.retain(|at| !is_fed(at)));
    let at = groups.into_iter().find_map(|group| conflict(of, &group))?;
    let text = format!(
        "two parts of `{}` are used here at once, and what lends it to the guard lends all of it: give what is read of it a name above",
        own.spelled
    );
    Some(Reason { span: of.span(at), text })
}

fn conflict(of: &LoopBody<'_>, places: &[ExprId]) -> Option<ExprId> {
    let uses: Vec<Use> = places.iter().map(|at| use_of(of, *at)).collect();
    let is_in = |one: &Use, around: Span| around.contains(of.span(one.at));
    let meets = |one: &Use| {
        let mut others = uses.iter().filter(|other| other.at != one.at);
        others.any(|other| {
            let is_operand = || one.operands.iter().any(|operand| is_in(other, of.span(*operand)));
            let is_beside = || one.held.is_some_and(|held| is_in(other, held));
            one.is_exclusive && is_operand() || (one.is_exclusive || other.is_exclusive) && is_beside()
        })
    };
    uses.iter().find(|one| meets(one)).map(|one| one.at)
}

fn use_of(of: &LoopBody<'_>, place: ExprId) -> Use {
    let mut found = Use { at: place, is_exclusive: false, operands: Vec::new(), held: None };
    let mut at = place;
    while let Some(parent) = of.parent(at) {
        match of.kind(parent) {
            ExprKind::Field { .. } | ExprKind::Deref(_) => at = parent,
            ExprKind::Index { base, index } if *base == at => {
                found.operands.push(*index);
                at = parent;
            }
            ExprKind::MethodCall { receiver, method, args, .. } if *receiver == at => {
                found.is_exclusive = may_change(of, parent, at, method);
                found.operands.extend(args);
                found.held = holds(of, parent).then(|| extent(of, parent)).flatten();
                break;
            }
            ExprKind::Assign { place, .. } if *place == at => {
                found.is_exclusive = true;
                break;
            }
            ExprKind::AssignOp { place, value, .. } if *place == at => {
                found.is_exclusive = true;
                if !is_number(of.typed.ty(at)) {
                    found.operands.push(*value);
                }
                break;
            }
            ExprKind::Reference { mutable, .. } => {
                found.is_exclusive = *mutable;
                found.held = extent(of, parent);
                break;
            }
            _ => break,
        }
    }
    found
}

/// Whether a method may change what it is called on.
fn may_change(of: &LoopBody<'_>, call: ExprId, receiver: ExprId, method: &str) -> bool {
    match of.typed.callees.get(&call) {
        Some(Callee::Resolved(callee)) if !callee.targets.is_empty() => {
            let index = of.program.index;
            callee.targets.iter().any(|target| index.function(*target).function.receiver == Some(Receiver::Exclusive))
        }
        _ => {
            let only_reads = matches!(
                method,
                "len"
                    | "is_empty"
                    | "iter"
                    | "first"
                    | "last"
                    | "get"
                    | "contains"
                    | "clone"
                    | "is_some"
                    | "is_none"
                    | "is_ok"
                    | "is_err"
            );
            !only_reads && !is_number(of.typed.ty(receiver))
        }
    }
}

fn is_number(ty: &Ty) -> bool {
    matches!(ty, Ty::Int | Ty::Float | Ty::Bool | Ty::Char)
}

/// Whether a value may hold a part of what it was made of. One whose type is not known seldom does.
fn holds(of: &LoopBody<'_>, value: ExprId) -> bool {
    let index = of.program.index;
    let ty = of.typed.ty(value);
    !matches!(ty, Ty::Unknown) && !is_owned(index, &index.scope_of(of.function), ty)
}

/// How far a value that holds a part of something is in use.
fn extent(of: &LoopBody<'_>, value: ExprId) -> Option<Span> {
    let mut at = value;
    loop {
        let parent = of.parent(at)?;
        match of.kind(parent) {
            ExprKind::Block(block) => {
                let stmt = block.stmts.iter().find(|stmt| stmt.span.contains(of.span(at)));
                return Some(stmt.map_or(of.span(at), |stmt| match &stmt.kind {
                    StmtKind::Let { pat, .. } => last_use(of, *pat).map_or(stmt.span, |last| stmt.span.to(last)),
                    StmtKind::Expr { .. } => stmt.span,
                }));
            }
            ExprKind::For { .. } | ExprKind::Match { .. } | ExprKind::If { .. } | ExprKind::While { .. } => {
                return Some(of.span(parent));
            }
            ExprKind::Let { .. } => at = parent,
            // Here the part was used.
            _ if !holds(of, parent) => return Some(of.span(parent)),
            _ => at = parent,
        }
    }
}

/// The last place where a variable of a pattern is named.
fn last_use(of: &LoopBody<'_>, pat: PatId) -> Option<Span> {
    let around = of.body.pat(pat).span;
    let locals = of.typed.expr_local.iter().filter(|(_, local)| around.contains(of.typed.local(**local).span));
    locals.map(|(id, _)| of.span(*id)).max_by_key(|span| span.end)
}
