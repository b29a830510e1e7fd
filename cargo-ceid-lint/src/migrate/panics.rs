//! Where code may panic: by what is there to panic, or by anything of which the language says that it may.

use std::collections::BTreeSet;

use super::calm::may_fail;
use super::locks::lock_behind;
use super::loops::Loops;
use super::mentions::Guarded;
use super::purity::destructors;
use super::signs::Code;
use crate::index::{Def, FunctionId, Index, Ty};
use crate::syntax::tree::{Body, Expr, ExprId, ExprKind, Literal, MacroKind, PatKind, TypeRef};
use crate::types::{Callee, TypedBody};

/// Which panics matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Panics {
    /// Those that stand there in so many words: an assertion, what is unwrapped.
    OnPurpose,
    /// Those of an index, of a division and of a loan as well, and those of functions that are called.
    Any,
    /// All those that may come in a release build, too, of what is not known to have none, and a subtraction that goes below zero: what
    /// somebody sees who goes on after it. Other sums and products overflow in a debug build only, and every counter would be one.
    Seen,
    /// Those of `Any`, and what fails in a state that the program never asked for another sample in: a subtraction that goes below
    /// zero, a loop that does not come to its end.
    Anew,
}

/// The law of a filter that may panic, or not end, where it runs once more than it does today.
pub(super) fn fails_anew(loops: &Loops<'_>, own: &Guarded) -> Option<FunctionId> {
    let is_unseen = |law: FunctionId| loops.program.index.function(law).function.body.is_none();
    own.laws().into_iter().find(|law| is_unseen(*law) || may_panic(loops, *law, Panics::Anew))
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
        if (0u32..).map(ExprId).take(body.exprs.len()).any(|id| panics_itself(loops, body, typed, id, which)) {
            return true;
        }
        open.extend(typed.callees.values().flat_map(targets));
        open.extend(loops.implicit(id).iter());
        if which == Panics::Seen {
            let all = (0u32..).map(ExprId).take(body.exprs.len());
            open.extend(all.flat_map(|id| dropped(program.index, body, typed, id)));
        }
    }
    false
}

/// Whether an expression of a function may panic, or what it runs.
pub(super) fn panics(loops: &Loops<'_>, function: FunctionId, id: ExprId, which: Panics) -> bool {
    let index = loops.program.index;
    let (Some(body), Some(typed)) = (&index.function(function).function.body, loops.program.typed(function)) else {
        return true;
    };
    let is_in_callee = || {
        let called = typed.callees.get(&id).into_iter().flat_map(targets);
        which != Panics::OnPurpose && called.into_iter().any(|target| may_panic(loops, target, which))
    };
    let is_in_passing = || {
        let run = || loops.implicit_at(function, id);
        which == Panics::Seen && run().into_iter().any(|target| may_panic(loops, target, which))
    };
    // The name of a closure stands where it is handed on to be called.
    let closure = match (typed.callees.get(&id), &body.expr(id).kind, typed.ty(id).peel()) {
        (Some(Callee::Closure(closure)), ..) => Some(*closure),
        (_, ExprKind::Path(_), Ty::Closure(closure)) => Some(ExprId(*closure)),
        _ => None,
    };
    // One that calls itself would be looked at for ever.
    let closure = closure.filter(|closure| !body.within(*closure).any(|inner| inner == id));
    let is_in_closure = || {
        let inside = closure.into_iter().flat_map(|closure| body.within(closure));
        which == Panics::Seen && inside.into_iter().any(|id| panics(loops, function, id, which))
    };
    panics_itself(loops, body, typed, id, which) || is_in_callee() || is_in_passing() || is_in_closure()
}

/// Whether what runs where a value is dropped that an expression makes, or takes away, may panic so that somebody sees it.
pub(super) fn panics_when_dropped(loops: &Loops<'_>, function: FunctionId, id: ExprId) -> bool {
    let index = loops.program.index;
    let (Some(body), Some(typed)) = (&index.function(function).function.body, loops.program.typed(function)) else {
        return true;
    };
    dropped(index, body, typed, id).into_iter().any(|target| may_panic(loops, target, Panics::Seen))
}

/// What runs where a value is dropped that an expression makes, or takes away.
fn dropped(index: &Index, body: &Body, typed: &TypedBody, id: ExprId) -> Vec<FunctionId> {
    let mut seen = BTreeSet::new();
    let mut of = |id: ExprId| destructors(index, typed.ty(id), &mut seen);
    match &body.expr(id).kind {
        ExprKind::Call { args, .. } => args.iter().chain([&id]).flat_map(|id| of(*id)).collect(),
        ExprKind::MethodCall { .. } | ExprKind::Struct { .. } => of(id),
        _ => Vec::new(),
    }
}

fn targets(callee: &Callee) -> Vec<FunctionId> {
    match callee {
        Callee::Resolved(resolved) => resolved.targets.clone(),
        _ => Vec::new(),
    }
}

fn panics_itself(loops: &Loops<'_>, body: &Body, typed: &TypedBody, id: ExprId, which: Panics) -> bool {
    let code = Code { loops, body, typed };
    let is_any = which != Panics::OnPurpose;
    let is_anew = which == Panics::Anew;
    let is_seen = which == Panics::Seen;
    if is_any && typed.callees.get(&id).is_some_and(|callee| unwinds(loops, callee)) || is_seen && may_fail(&code, id) {
        return true;
    }
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
            ("clamp", 2) => is_seen && !is_ordered(&code, args[0], args[1]),
            ("remove" | "swap_remove" | "split_off", 1) | ("insert" | "swap", 2) => {
                is_any && is_numbered(typed.ty(*receiver))
            }
            _ => false,
        },
        ExprKind::Index { base, index } => is_any && !is_within(&code, *base, *index),
        ExprKind::Binary { op, lhs, rhs: by } | ExprKind::AssignOp { op, place: lhs, value: by } => {
            let is_below = || *op == "-" && code.may_go_below(*lhs, *by);
            is_any && divides(op, typed.ty(*lhs)) && !is_other_than_zero(&code, *by)
                || (is_anew || is_seen) && is_below()
        }
        ExprKind::Loop { .. } => is_anew,
        ExprKind::While { condition, .. } => is_anew && !drains(body, *condition),
        ExprKind::For { iterable, .. } => {
            is_anew && matches!(body.expr(*iterable).kind, ExprKind::Range { end: None, .. })
        }
        _ => false,
    }
}

/// Whether a call never comes back and may panic on its way: a function of the standard library that only does that, or one whose code
/// is not read.
fn unwinds(loops: &Loops<'_>, callee: &Callee) -> bool {
    match callee {
        Callee::External(path) => {
            matches!(path.strip_prefix("std::panic::"), Some("resume_unwind" | "panic_any"))
        }
        Callee::Resolved(resolved) => resolved.targets.iter().any(|target| {
            let function = &loops.program.index.function(*target).function;
            function.body.is_none() && function.output == TypeRef::Never
        }),
        _ => false,
    }
}

/// Whether the elements of a collection go by numbers, of which one too large panics.
fn is_numbered(ty: &Ty) -> bool {
    match ty.peel() {
        Ty::Array(..) | Ty::Slice(_) => true,
        Ty::External(path, _) => matches!(path.as_str(), "std::vec::Vec" | "std::collections::VecDeque"),
        _ => false,
    }
}

/// Whether an index is a number below the length of its array: by its value, or because it is counted up to that.
fn is_within(code: &Code<'_>, base: ExprId, index: ExprId) -> bool {
    let Code { loops, body, typed } = code;
    let Ty::Array(_, array) = typed.ty(base).peel() else {
        return matches!(body.expr(index).kind, ExprKind::Range { start: None, end: None, .. });
    };
    let text = |id: ExprId| loops.program.sources.snippet(body.expr(id).span);
    let is_length = |id: ExprId| match &body.expr(id).kind {
        ExprKind::MethodCall { receiver, method, .. } => method == "len" && text(*receiver) == text(base),
        _ => {
            let is_least = array.value.zip(code.constant(id)).is_some_and(|(length, number)| number <= length);
            is_least || array.value.is_none() && array.text == text(id)
        }
    };
    match &body.expr(index).kind {
        ExprKind::Range { start: None, end: None, .. } => true,
        ExprKind::Binary { op, rhs, .. } if *op == "%" => is_length(*rhs),
        _ if let Some(number) = code.constant(index) => array.value.is_some_and(|length| number < length),
        ExprKind::Path(_) => typed.expr_local.get(&index).is_some_and(|local| {
            let is_counted = |expr: &Expr| match expr.kind {
                ExprKind::For { pat, iterable, .. } => {
                    let is_it = typed.pat_local.get(&pat) == Some(local)
                        && matches!(body.pat(pat).kind, PatKind::Bind { mutable: false, .. });
                    let end = match body.expr(iterable).kind {
                        ExprKind::Range { end, inclusive: false, .. } => end,
                        _ => None,
                    };
                    is_it && end.is_some_and(is_length)
                }
                _ => false,
            };
            body.exprs.iter().any(is_counted)
        }),
        _ => false,
    }
}

impl Code<'_> {
    /// The number that an expression is: a literal, or a constant with one.
    pub(super) fn constant(&self, id: ExprId) -> Option<u64> {
        self.written(id, |body, id| match body.expr(id).kind {
            ExprKind::Literal(Literal::Int(number, _)) => number,
            _ => None,
        })
    }

    /// The same for a number of any kind, which may have a sign.
    pub(super) fn number(&self, id: ExprId) -> Option<f64> {
        if let ExprKind::Negate(inner) = self.body.expr(id).kind {
            return self.number(inner).map(|number| -number);
        }
        self.written(id, |body, id| match &body.expr(id).kind {
            ExprKind::Literal(Literal::Int(number, _)) => Some(f64::from(u32::try_from((*number)?).ok()?)),
            ExprKind::Literal(literal) => literal.float(),
            _ => None,
        })
    }

    /// What is read of an expression, or of the value of the constant that it names.
    fn written<T>(&self, id: ExprId, read: impl Fn(&Body, ExprId) -> Option<T>) -> Option<T> {
        match self.typed.expr_def.get(&id) {
            Some(Def::Value(value)) => {
                let item = &self.loops.program.index.value(*value).item;
                let value = item.value.as_ref().filter(|_| !item.is_static)?;
                read(value, value.root)
            }
            _ => read(self.body, id),
        }
    }
}

/// Whether the head of a loop takes items out of something until there is none: `while let Some(item) = queue.pop()`.
fn drains(body: &Body, condition: ExprId) -> bool {
    let ExprKind::Let { value, .. } = body.expr(condition).kind else { return false };
    matches!(&body.expr(value).kind, ExprKind::MethodCall { method, args, .. } if args.is_empty()
        && matches!(method.as_str(), "pop" | "pop_front" | "pop_back" | "dequeue"))
}

fn divides(op: &str, ty: &Ty) -> bool {
    matches!(op, "/" | "%") && *ty.peel() == Ty::Int
}

/// Whether the bounds of a `clamp` are numbers of which the first one is not the larger one: `-1.0, LIMIT`.
fn is_ordered(code: &Code<'_>, low: ExprId, high: ExprId) -> bool {
    code.number(low).zip(code.number(high)).is_some_and(|(low, high)| low <= high)
}

/// Whether a divisor is a number other than zero.
fn is_other_than_zero(code: &Code<'_>, id: ExprId) -> bool {
    code.constant(id).is_some_and(|number| number != 0)
}
