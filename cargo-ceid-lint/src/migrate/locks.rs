//! Filters behind a `Mutex` or `RefCell`: a guard can hold what a variable of the loop has locked for the rest of the iteration.

use super::body::LoopBody;
use super::sites::Place;
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, PatId, PatKind, StmtKind};
use crate::types::{Callee, LocalId, opens_cell};

/// The statement of the loop that locks the filter until the end of the iteration: `let mut kf = shared.lock().unwrap();`
pub(super) fn lock_of(of: &LoopBody<'_>, place: &Place) -> Option<Span> {
    let ExprKind::Block(block) = of.kind(of.block) else { return None };
    let is_it = |pat| {
        of.typed.pat_local.get(&pat) == Some(&place.local)
            && matches!(of.body.pat(pat).kind, PatKind::Bind { by_ref: false, sub: None, .. })
    };
    let stmt = block.stmts.iter().find(|stmt| match &stmt.kind {
        StmtKind::Let { pat, init: Some(init), otherwise: None, .. } => is_it(*pat) && locked(of, *init).is_some(),
        _ => false,
    })?;
    (place.fields.is_empty() && stmt.cfg.is_none()).then_some(stmt.span)
}

/// What an expression locks: `shared` in `shared.lock().unwrap()`.
pub(super) fn locked(of: &LoopBody<'_>, id: ExprId) -> Option<ExprId> {
    let ExprKind::MethodCall { receiver, method, args, .. } = of.kind(id) else { return None };
    // A lock that a panic has left may be taken as any other.
    let is_taken_anyway =
        || matches!(args.as_slice(), [taker] if of.written(*taker).ends_with("PoisonError::into_inner"));
    // What a function of the analysed code gives need not be a lock.
    let is_own = matches!(of.typed.callees.get(&id), Some(Callee::Resolved(callee)) if !callee.targets.is_empty());
    match (method.as_str(), args.len()) {
        ("lock" | "write" | "borrow_mut", 0) if !is_own => Some(*receiver),
        ("unwrap", 0) | ("expect", 1) => locked(of, *receiver),
        ("unwrap_or_else", 1) if is_taken_anyway() => locked(of, *receiver),
        _ => None,
    }
}

/// Whether a variable lends all that a lock holds at once, whatever the loop takes of it: `let mut state = shared.lock().unwrap();`
pub(super) fn is_lock_guard(of: &LoopBody<'_>, local: LocalId) -> bool {
    let name = of.typed.local(local).span;
    let binds = |pat: PatId| of.body.pat(pat).span.contains(name);
    of.body.exprs.iter().any(|expr| match &expr.kind {
        ExprKind::Let { pat, value, .. } => binds(*pat) && opens(of, *value),
        ExprKind::Match { scrutinee, arms } => arms.iter().any(|arm| binds(arm.pat)) && opens(of, *scrutinee),
        ExprKind::Block(block) => block.stmts.iter().any(|stmt| match &stmt.kind {
            StmtKind::Let { pat, init: Some(init), .. } => binds(*pat) && opens(of, *init),
            _ => false,
        }),
        _ => false,
    })
}

/// Whether an expression is what a lock gives, however its failure is dealt with. A reference to what it holds is none.
fn opens(of: &LoopBody<'_>, id: ExprId) -> bool {
    match of.kind(id) {
        ExprKind::MethodCall { receiver, method, .. } => {
            let is_own =
                matches!(of.typed.callees.get(&id), Some(Callee::Resolved(callee)) if !callee.targets.is_empty());
            !is_own && method != "get_mut" && opens_cell(method) || opens(of, *receiver)
        }
        ExprKind::Try(inner) | ExprKind::Await(inner) => opens(of, *inner),
        ExprKind::Match { scrutinee, .. } => opens(of, *scrutinee),
        ExprKind::Block(block) => block.tail.is_some_and(|tail| opens(of, tail)),
        ExprKind::If { then, otherwise, .. } => opens(of, *then) || otherwise.is_some_and(|other| opens(of, other)),
        _ => false,
    }
}

/// Whether an expression is what a lock holds, which is there without locking it for who has all of it: `self.kf.get_mut()`.
pub(super) fn is_opened_alone(of: &LoopBody<'_>, id: ExprId) -> bool {
    match of.kind(id) {
        ExprKind::MethodCall { receiver, method, .. } => match method.as_str() {
            "get_mut" => lock_behind(of.typed.ty(*receiver)).is_some(),
            "unwrap" | "expect" => is_opened_alone(of, *receiver),
            _ => false,
        },
        _ => false,
    }
}

/// The lock that a value is, or that it leads to: `Mutex` for an `Arc<Mutex<f32>>`.
pub(super) fn lock_behind(ty: &Ty) -> Option<&str> {
    let Ty::External(path, args) = ty.peel() else { return None };
    match path.rsplit("::").next()? {
        name @ ("RefCell" | "Mutex" | "RwLock") => Some(name),
        "Rc" | "Arc" | "Box" => lock_behind(args.first()?),
        _ => None,
    }
}
