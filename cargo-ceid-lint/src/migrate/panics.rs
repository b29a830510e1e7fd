//! Where code may panic: by what is there to panic, or by anything of which the language says that it may.

use std::collections::BTreeSet;

use super::locks::lock_behind;
use super::loops::Loops;
use crate::index::{FunctionId, Ty};
use crate::syntax::tree::{Body, ExprId, ExprKind, Literal, MacroKind};
use crate::types::{Callee, TypedBody};

/// Which panics matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Panics {
    /// Those that stand there in so many words: an assertion, what is unwrapped.
    OnPurpose,
    /// Those of an index, of a division and of a loan as well, and those of functions that are called.
    Any,
}

/// Whether a function may panic.
pub(super) fn may_panic(loops: &Loops<'_>, function: FunctionId, which: Panics) -> bool {
    let program = loops.program;
    let mut seen = BTreeSet::new();
    let mut open = vec![function];
    while let Some(id) = open.pop() {
        if !seen.insert(id) {
            continue;
        }
        let (Some(body), Some(typed)) = (&program.index.function(id).function.body, program.typed(id)) else {
            continue;
        };
        if (0u32..).map(ExprId).take(body.exprs.len()).any(|id| panics_itself(body, typed, id, which)) {
            return true;
        }
        open.extend(typed.callees.values().flat_map(targets));
        open.extend(loops.implicit(id).iter());
    }
    false
}

/// Whether an expression may panic, or what it calls.
pub(super) fn panics(loops: &Loops<'_>, body: &Body, typed: &TypedBody, id: ExprId, which: Panics) -> bool {
    let is_in_callee = || {
        let called = typed.callees.get(&id).into_iter().flat_map(targets);
        which == Panics::Any && called.into_iter().any(|target| may_panic(loops, target, which))
    };
    panics_itself(body, typed, id, which) || is_in_callee()
}

fn targets(callee: &Callee) -> Vec<FunctionId> {
    match callee {
        Callee::Resolved(resolved) => resolved.targets.clone(),
        _ => Vec::new(),
    }
}

fn panics_itself(body: &Body, typed: &TypedBody, id: ExprId, which: Panics) -> bool {
    let is_any = which == Panics::Any;
    match &body.expr(id).kind {
        ExprKind::Macro(call) => match call.kind {
            MacroKind::Assert(..) | MacroKind::AssertCompare(..) | MacroKind::Diverges(_) => true,
            MacroKind::DebugOnly(..) => is_any,
            _ => false,
        },
        ExprKind::MethodCall { receiver, method, args, .. } => match (method.as_str(), args.len()) {
            ("unwrap", 0) | ("expect", 1) => true,
            ("borrow" | "borrow_mut", 0) => is_any && lock_behind(typed.ty(*receiver)) == Some("RefCell"),
            ("unwrap_err", 0)
            | ("expect_err" | "split_at" | "split_at_mut" | "copy_from_slice" | "clone_from_slice", 1) => is_any,
            _ => false,
        },
        ExprKind::Index { base, index } => is_any && !is_within(body, typed.ty(*base), *index),
        ExprKind::Binary { op, lhs, rhs } => is_any && divides(op, typed.ty(*lhs)) && !is_other_than_zero(body, *rhs),
        ExprKind::AssignOp { op, place, value } => {
            is_any && divides(op, typed.ty(*place)) && !is_other_than_zero(body, *value)
        }
        _ => false,
    }
}

/// Whether an index is a number below the length of its array.
fn is_within(body: &Body, array: &Ty, index: ExprId) -> bool {
    match (array.peel(), &body.expr(index).kind) {
        (Ty::Array(_, length), ExprKind::Literal(Literal::Int(Some(number), _))) => {
            length.value.is_some_and(|length| *number < length)
        }
        (_, ExprKind::Range { start: None, end: None, .. }) => true,
        _ => false,
    }
}

fn divides(op: &str, ty: &Ty) -> bool {
    matches!(op, "/" | "%") && *ty.peel() == Ty::Int
}

fn is_other_than_zero(body: &Body, id: ExprId) -> bool {
    matches!(&body.expr(id).kind, ExprKind::Literal(Literal::Int(Some(number), _)) if *number != 0)
}
