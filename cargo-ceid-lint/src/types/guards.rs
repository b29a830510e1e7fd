//! Guards of cells and locks: whose method a call on one is. A guard has next to none of its own, what a lock of the standard
//! library gives has those of `Result`, and of many locks is not known which of both they give.

use super::builtin::is_pointer;
use super::infer::Infer;
use crate::index::Ty;
use crate::syntax::tree::{ExprId, ExprKind};

/// The type of what is surely a guard. It is named as what a lock gives, which most code need not tell from a guard.
const GUARD: &str = "std::cell::LockResult";

/// What a method of a cell or lock gives that opens it.
pub(super) fn opened(cell: &str, method: &str, content: Ty) -> Ty {
    if method == "get_mut" && gives_guard(cell, method) {
        return Ty::Ref(true, Box::new(content));
    }
    let path = if gives_guard(cell, method) { GUARD } else { "std::sync::LockResult" };
    Ty::std(path, vec![Ty::Ref(true, Box::new(content))])
}

/// Whether a type is surely a guard, so that all methods but those of pointers are those of what it opens.
pub(super) fn is_guard(ty: &Ty) -> bool {
    matches!(ty, Ty::External(path, _) if path == GUARD)
}

/// Whether a method of a cell or lock gives a guard, or a reference, and no result of one.
fn gives_guard(cell: &str, method: &str) -> bool {
    let krate = cell.split("::").next().unwrap_or_default();
    let is_of_async = matches!(krate, "tokio" | "futures" | "futures_util" | "async_lock" | "async_std" | "smol");
    match method {
        _ if method.starts_with("try_") => false,
        "borrow" | "borrow_mut" | "borrow_ref" | "borrow_ref_mut" => true,
        "get_mut" => matches!(krate, "std" | "parking_lot" | "spin") && !cell.starts_with("std::sync::"),
        _ => is_of_async || matches!(krate, "parking_lot" | "lock_api" | "spin" | "embassy_sync"),
    }
}

impl Infer<'_> {
    /// Whether a method that is called on a guard or pointer is that of what lies behind it, although wrappers of that name have a
    /// method of the same name: `cell.borrow_mut().filter(x)` is no `Option::filter`.
    pub(super) fn is_of_content(&self, ty: &Ty, method: &str, args: &[ExprId]) -> bool {
        let Ty::External(path, params) = ty else { return false };
        let Some(content) = params.first() else { return false };
        let name = path.rsplit("::").next().unwrap_or_default();
        if is_guard(ty) {
            return !matches!(method, "deref" | "deref_mut");
        }
        let has_own = || {
            let content = self.behind_pointers(content);
            !self.methods_of(&content, method).is_empty()
                || self.index.law_spec(&content).is_some_and(|spec| spec.group(method).is_some())
        };
        match name {
            "LockResult" => !self.is_of_result(method, args) && has_own(),
            // Whoever wants that of the pointer has to import the trait.
            _ if is_pointer(name) => matches!(method, "borrow" | "borrow_mut") && has_own(),
            _ => false,
        }
    }

    /// Whether a method may be one of `Result` or `Option`, called with these arguments.
    fn is_of_result(&self, method: &str, args: &[ExprId]) -> bool {
        let given = |at: usize| args.get(at).map(|arg| &self.body.expr(*arg).kind);
        let is_function = |at: usize| matches!(given(at), Some(ExprKind::Closure(_) | ExprKind::Path(_)));
        match method {
            "unwrap" | "ok" | "err" | "as_mut" | "as_ref" | "as_deref" | "as_deref_mut" | "iter" | "iter_mut"
            | "into_iter" | "is_ok" | "is_err" | "is_some" | "is_none" | "into_inner" | "unwrap_err"
            | "unwrap_or_default" | "unwrap_unchecked" | "take" | "clone" | "get_mut" | "get_ref" => args.is_empty(),
            "expect" | "expect_err" => matches!(given(0), Some(ExprKind::Literal(_) | ExprKind::Path(_))),
            "map" | "and_then" | "or_else" | "unwrap_or_else" | "map_err" | "inspect" | "inspect_err" | "is_ok_and"
            | "is_err_and" | "is_some_and" | "filter" => is_function(0),
            "map_or" | "map_or_else" => is_function(1),
            "and" | "or" | "unwrap_or" | "ok_or" | "context" | "with_context" => args.len() == 1,
            _ => false,
        }
    }
}
