//! Parts of a filter that are used at the same time. What lends a filter to its guard lends all of it, where a variable lends each field
//! by itself, and waits with a method's receiver until its arguments are there.

use super::Reason;
use super::body::LoopBody;
use super::each::{Reached, elements};
use super::mentions::{Guarded, Mention};
use super::owned::is_owned;
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, MacroExpr, PatId, Receiver, StmtKind};
use crate::types::Callee;

/// How a filter is used at one place.
struct Use {
    /// The filter there.
    at: ExprId,
    /// Where it is lent: a place that is assigned to, only when the value is there.
    lent: Span,
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
    let is_closure = |id: &ExprId| matches!(of.kind(*id), ExprKind::Closure(_));
    let closures =
        of.inside.iter().copied().filter(is_closure).filter_map(|closure| use_by_closure(of, closure, &uses));
    let closures: Vec<Use> = closures.collect();
    let uses: Vec<Use> = uses.into_iter().chain(closures).collect();
    let is_in = |one: &Use, around: Span| around.contains(one.lent);
    let meets = |one: &Use| {
        // What a closure names is a part of what it holds.
        let is_inside = |other: &Use| of.span(one.at).contains(of.span(other.at)) && is_closure(&one.at);
        let mut others = uses.iter().filter(|other| other.at != one.at && !is_inside(other));
        others.any(|other| {
            let is_operand = || one.operands.iter().any(|operand| is_in(other, of.span(*operand)));
            let is_beside = || one.held.is_some_and(|held| is_in(other, held));
            one.is_exclusive && is_operand() || (one.is_exclusive || other.is_exclusive) && is_beside()
        })
    };
    uses.iter().find(|one| meets(one)).map(|one| one.at)
}

fn use_of(of: &LoopBody<'_>, place: ExprId) -> Use {
    let mut found = Use { at: place, lent: of.span(place), is_exclusive: false, operands: Vec::new(), held: None };
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
                found.lent = behind(of.span(parent));
                break;
            }
            ExprKind::AssignOp { place, value, .. } if *place == at => {
                found.is_exclusive = true;
                match is_number(of.typed.ty(at)) {
                    true => found.lent = behind(of.span(parent)),
                    false => found.operands.push(*value),
                }
                break;
            }
            ExprKind::Reference { mutable, .. } => {
                found.is_exclusive = *mutable;
                found.held = extent(of, parent);
                break;
            }
            // What is written to is lent while that is made which is written.
            ExprKind::Macro(call) if is_writing(call) && of.body.children(parent).first() == Some(&at) => {
                found.is_exclusive = true;
                found.operands.extend(of.body.children(parent).into_iter().skip(1));
                break;
            }
            _ => break,
        }
    }
    found
}

fn behind(span: Span) -> Span {
    Span { start: span.end, ..span }
}

fn is_writing(call: &MacroExpr) -> bool {
    matches!(call.path.rsplit("::").next().map(str::trim), Some("write" | "writeln"))
}

/// How a closure holds the parts of a filter that it names: all of it, for as long as the closure is in use.
fn use_by_closure(of: &LoopBody<'_>, closure: ExprId, inside: &[Use]) -> Option<Use> {
    let own = of.span(closure);
    let mut inside = inside.iter().filter(|one| own.contains(of.span(one.at))).peekable();
    inside.peek()?;
    let is_exclusive = inside.any(|one| one.is_exclusive);
    Some(Use { at: closure, lent: own, is_exclusive, operands: Vec::new(), held: extent(of, closure) })
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

/// The last place where a variable of a pattern is named, or called with what is given to it.
fn last_use(of: &LoopBody<'_>, pat: PatId) -> Option<Span> {
    let around = of.body.pat(pat).span;
    let locals = of.typed.expr_local.iter().filter(|(_, local)| around.contains(of.typed.local(**local).span));
    let whole = |id: ExprId| match of.parent(id) {
        Some(call) if matches!(of.kind(call), ExprKind::Call { callee, .. } if *callee == id) => of.span(call),
        _ => of.span(id),
    };
    locals.map(|(id, _)| whole(*id)).max_by_key(|span| span.end)
}
