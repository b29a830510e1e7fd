//! Filters behind a `Mutex` or `RefCell`: a guard can hold what a variable of the loop has locked for the rest of the iteration.

use super::body::LoopBody;
use super::sites::Place;
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, PatKind, StmtKind};
use crate::types::Callee;

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
    // What a function of the analysed code gives need not be a lock.
    let is_own = matches!(of.typed.callees.get(&id), Some(Callee::Resolved(callee)) if !callee.targets.is_empty());
    match (method.as_str(), args.len()) {
        ("lock" | "write" | "borrow_mut", 0) if !is_own => Some(*receiver),
        ("unwrap", 0) | ("expect", 1) => locked(of, *receiver),
        _ => None,
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
