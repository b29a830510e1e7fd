//! What is there before the loop and stays as it is: a reference to it can be kept until the end of a cycle.

use super::body::LoopBody;
use super::iteration::{binds, zipped};
use super::mentions::{is_about, is_format_operand};
use super::owned::is_owned;
use super::sites::{Place, place_of};
use crate::index::{Def, FunctionId, Ty};
use crate::syntax::tree::{ExprId, ExprKind, PatId, PatKind, Receiver, TypeRef};
use crate::types::{Callee, LocalId};

/// Whether an expression is a reference to what is there before the loop and stays: `row` of `for row in &rows`, `&rows[k]`,
/// `table.row(k)`.
pub(super) fn is_lasting(of: &LoopBody<'_>, id: ExprId) -> bool {
    match of.kind(id) {
        ExprKind::Path(_) => is_lasting_item(of, id) || is_lasting_variable(of, id),
        ExprKind::Reference { mutable: false, raw: false, value } => stays(of, *value),
        ExprKind::MethodCall { receiver, args, .. } => {
            lends(of, id, args) && (is_lasting(of, *receiver) || stays(of, *receiver))
        }
        _ => false,
    }
}

/// Whether the place that an expression is belongs to such a value.
fn stays(of: &LoopBody<'_>, id: ExprId) -> bool {
    if let Some(place) = place_of(of, id) {
        return is_above_the_loop(of, place.local) && is_only_read(of, &place)
            || matches!(of.kind(id), ExprKind::Field { base, .. } if is_lasting(of, *base) || stays(of, *base));
    }
    match of.kind(id) {
        ExprKind::Field { base, .. } | ExprKind::Index { base, .. } => is_lasting(of, *base) || stays(of, *base),
        ExprKind::Deref(inner) => is_lasting(of, *inner),
        ExprKind::Path(_) => match of.typed.expr_def.get(&id) {
            Some(Def::Value(value)) => of.program.index.value(*value).item.is_static,
            _ => false,
        },
        _ => false,
    }
}

/// Whether an expression is an item of what the head of the loop runs over by reference: `for part in data.chunks(4)`, `for row in
/// &rows`.
pub(super) fn is_lasting_item(of: &LoopBody<'_>, id: ExprId) -> bool {
    let ExprKind::For { iterable, pat, .. } = of.kind(of.whole) else { return false };
    let local = of.typed.expr_local.get(&id);
    matches!(of.typed.ty(id), Ty::Ref(..)) && local.is_some_and(|local| is_item(of, *iterable, *pat, *local))
}

fn is_item(of: &LoopBody<'_>, iterable: ExprId, pat: PatId, local: LocalId) -> bool {
    let parts: &[PatId] = match &of.body.pat(pat).kind {
        PatKind::Tuple(parts) => parts,
        _ if of.typed.pat_local.get(&pat) == Some(&local) => &[],
        _ => return false,
    };
    if let ([first, second], Some((one, other))) = (parts, zipped(of, iterable)) {
        let (own, pat) = if binds(of, *first, local) { (one, *first) } else { (other, *second) };
        return is_item(of, own, pat, local);
    }
    match (of.kind(iterable), parts) {
        (ExprKind::MethodCall { receiver, method, args, .. }, [_, item])
            if method == "enumerate" && args.is_empty() =>
        {
            is_item(of, *receiver, *item, local)
        }
        (ExprKind::MethodCall { receiver, method, .. }, _)
            if matches!(method.as_str(), "rev" | "skip" | "take" | "step_by") =>
        {
            is_item(of, *receiver, pat, local)
        }
        (ExprKind::MethodCall { receiver, method, .. }, []) => {
            let is_of_slices =
                matches!(method.as_str(), "iter" | "chunks" | "chunks_exact" | "rchunks" | "rchunks_exact" | "windows");
            is_of_slices && is_slice(of.typed.ty(*receiver)) && is_before_the_loop(of, *receiver)
        }
        (ExprKind::Reference { mutable: false, raw: false, value }, []) => {
            is_slice(of.typed.ty(*value)) && is_before_the_loop(of, *value)
        }
        (_, []) => {
            let ty = of.typed.ty(iterable);
            matches!(ty, Ty::Ref(false, _)) && is_slice(ty) && is_before_the_loop(of, iterable)
        }
        _ => false,
    }
}

/// Whether an expression is a variable above the loop that is a shared reference, and stays the same one.
fn is_lasting_variable(of: &LoopBody<'_>, id: ExprId) -> bool {
    let Some(local) = of.typed.expr_local.get(&id).copied() else { return false };
    let place = Place { local, fields: Vec::new(), element: None };
    matches!(of.typed.ty(id), Ty::Ref(false, _)) && is_above_the_loop(of, local) && is_only_read(of, &place)
}

/// Whether a method of the analysed code lends a part of its receiver, and nothing else can be what it lends.
fn lends(of: &LoopBody<'_>, call: ExprId, args: &[ExprId]) -> bool {
    let index = of.program.index;
    let Some(Callee::Resolved(callee)) = of.typed.callees.get(&call) else { return false };
    let is_lent = |target: &FunctionId| {
        let function = &index.function(*target).function;
        function.receiver == Some(Receiver::Shared)
            && matches!(function.output, TypeRef::Reference { mutable: false, .. })
    };
    let is_plain = |arg: &ExprId| is_owned(index, &index.scope_of(of.function), of.typed.ty(*arg));
    callee.law.is_none()
        && !callee.targets.is_empty()
        && callee.targets.iter().all(is_lent)
        && args.iter().all(is_plain)
}

/// Whether the loop, its head included, does nothing with a place but look at it.
fn is_only_read(of: &LoopBody<'_>, place: &Place) -> bool {
    let name = &of.typed.local(place.local).name;
    of.body.within(of.whole).all(|id| match of.kind(id) {
        ExprKind::Opaque(call) => !call.mentions.contains(name),
        _ => !is_about(of, place, id) || is_look(of, id),
    })
}

/// Whether the value that an expression leads to, or the part of it that is named here, is only looked at.
fn is_look(of: &LoopBody<'_>, mut at: ExprId) -> bool {
    let index = of.program.index;
    let mut is_shared = false;
    while let Some(parent) = of.parent(at) {
        // What is behind a shared reference does not change.
        is_shared |= matches!(of.typed.ty(at), Ty::Ref(false, _));
        match of.kind(parent) {
            ExprKind::Assign { place, .. } | ExprKind::AssignOp { place, .. } if *place == at => return false,
            ExprKind::Field { .. } | ExprKind::Deref(_) => at = parent,
            ExprKind::Index { base, .. } if *base == at => at = parent,
            ExprKind::Reference { mutable, raw, .. } => return !mutable && !raw,
            _ if is_shared => return true,
            ExprKind::MethodCall { receiver, method, .. } if *receiver == at => {
                return match of.typed.callees.get(&parent) {
                    Some(Callee::Resolved(callee)) => {
                        let is_shared =
                            |target: &FunctionId| index.function(*target).function.receiver == Some(Receiver::Shared);
                        !callee.targets.is_empty() && callee.targets.iter().all(is_shared)
                    }
                    _ => {
                        is_shared_builtin(method)
                            && matches!(of.typed.ty(at).peel(), Ty::External(..) | Ty::Array(..) | Ty::Slice(_))
                    }
                };
            }
            ExprKind::Macro(_) if is_format_operand(of, at) => return true,
            _ => {
                let ty = of.typed.ty(at);
                return matches!(ty, Ty::Int | Ty::Float | Ty::Bool | Ty::Char) || index.is_copy(ty);
            }
        }
    }
    false
}

/// Methods of arrays, slices and vectors that only look.
fn is_shared_builtin(method: &str) -> bool {
    matches!(
        method,
        "iter"
            | "len"
            | "is_empty"
            | "first"
            | "last"
            | "get"
            | "as_slice"
            | "chunks"
            | "windows"
            | "contains"
            | "clone"
            | "to_vec"
    )
}

pub(super) fn is_slice(ty: &Ty) -> bool {
    match ty.peel() {
        Ty::Slice(_) | Ty::Array(..) => true,
        Ty::External(path, _) => path == "std::vec::Vec",
        _ => false,
    }
}

/// Whether an expression is a variable that is declared above the loop, or a field of one.
fn is_before_the_loop(of: &LoopBody<'_>, id: ExprId) -> bool {
    place_of(of, id).is_some_and(|place| is_above_the_loop(of, place.local))
}

fn is_above_the_loop(of: &LoopBody<'_>, local: LocalId) -> bool {
    of.typed.local(local).span.start < of.span(of.whole).start
}
