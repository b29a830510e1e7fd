//! Whether anybody sees the state of a filter after its loop was left.

use super::body::LoopBody;
use super::mentions::{Guarded, held};
use super::text::words;
use crate::index::{Index, TraitName, Ty};
use crate::source::Span;
use crate::syntax::tree::{BlockKind, ExprId, ExprKind};

/// Whether the state of a filter may be seen once the loop is left; if not, a law that runs on the way out changes nothing.
pub(super) fn is_observed(of: &LoopBody<'_>, own: &Guarded) -> bool {
    may_be_seen_elsewhere(of, own) || read_later(of, own).is_some()
}

/// Whether its state may be seen otherwise than by its name behind the loop.
fn may_be_seen_elsewhere(of: &LoopBody<'_>, own: &Guarded) -> bool {
    let local = of.typed.local(own.place.local);
    let ty = &local.ty;
    if own_value(ty).is_none() || own_value(&own.ty).is_none() || has_destructor(of.program.index, &own.ty) {
        return true;
    }
    if !own.place.fields.is_empty() && has_destructor(of.program.index, ty) {
        return true;
    }
    // What is declared outside of a loop or closure around this loop is there again when that runs again.
    of.ancestors(of.whole).any(|around| of.kind(around).may_repeat() && !of.span(around).contains(local.span))
}

/// Where the variable of a filter is first named behind the loop, if it has no other name.
pub(super) fn read_later(of: &LoopBody<'_>, own: &Guarded) -> Option<Span> {
    if may_be_seen_elsewhere(of, own) {
        return None;
    }
    let name = &of.typed.local(own.place.local).name;
    let Span { file, end, .. } = of.span(of.whole);
    let rest = of.text.get(end as usize..of.span(of.body.root).end as usize).unwrap_or_default();
    let length = u32::try_from(name.len()).unwrap_or_default();
    let spans = words(rest, name).map(|at| {
        let start = end + u32::try_from(at).unwrap_or_default();
        Span::new(file, start, start + length)
    });
    let others = other_branches(of);
    spans.into_iter().find(|span| !others.iter().any(|other| other.contains(*span)))
}

/// The branches of the choices around the loop in which it does not lie.
fn other_branches(of: &LoopBody<'_>) -> Vec<Span> {
    let mut own = of.whole;
    let mut found = Vec::new();
    for around in of.ancestors(of.whole) {
        let branches = match of.kind(around) {
            ExprKind::If { then, otherwise, .. } => std::iter::once(*then).chain(*otherwise).collect(),
            ExprKind::Match { arms, .. } => arms.iter().map(|arm| arm.body).collect(),
            _ => Vec::new(),
        };
        if branches.contains(&own) {
            found.extend(branches.into_iter().filter(|branch| *branch != own).map(|branch| of.span(branch)));
        }
        own = around;
    }
    found
}

/// Whether a filter is there after a panic has left the function, the closure or the block of its loop: it is lent to that.
pub(super) fn outlives_panic(of: &LoopBody<'_>, own: &Guarded) -> bool {
    let local = of.typed.local(own.place.local);
    let is_around = |at: ExprId| match of.kind(at) {
        ExprKind::Closure(_) => !of.span(at).contains(local.span),
        ExprKind::Block(block) => block.kind == BlockKind::Async && !of.span(at).contains(local.span),
        _ => false,
    };
    own.locked.is_some()
        || own.is_lock_guard
        || own_value(&local.ty).is_none()
        || own_value(&own.ty).is_none()
        || of.ancestors(of.whole).any(is_around)
}

/// Whether a filter is gone where the loop is left by `return` or `?`: it is a variable of what is left.
pub(super) fn is_dropped_at(of: &LoopBody<'_>, own: &Guarded, exit: ExprId) -> bool {
    let local = of.typed.local(own.place.local);
    let index = of.program.index;
    let is_value = own_value(&local.ty).is_some() && own_value(&own.ty).is_some();
    let is_quiet =
        !has_destructor(index, &own.ty) && (own.place.fields.is_empty() || !has_destructor(index, &local.ty));
    // A closure or another kind of block around the loop is what is left instead.
    let is_outside = of.ancestors(of.whole).any(|around| {
        let is_left = match of.kind(around) {
            ExprKind::Closure(_) => true,
            ExprKind::Block(block) => matches!(block.kind, BlockKind::Async | BlockKind::Try),
            ExprKind::Opaque(_) | ExprKind::Macro(_) => true,
            _ => false,
        };
        is_left && !of.span(around).contains(local.span)
    });
    matches!(of.kind(exit), ExprKind::Return(_) | ExprKind::Try(_)) && is_value && is_quiet && !is_outside
}

/// Whether a filter is there after the future in which its loop waits was dropped.
pub(super) fn outlives_future(of: &LoopBody<'_>, own: &Guarded) -> bool {
    let local = of.typed.local(own.place.local);
    if own_value(&local.ty).is_none() || own_value(&own.ty).is_none() || has_destructor(of.program.index, &own.ty) {
        return true;
    }
    // A block that borrows what is declared above it is a future of its own.
    let future = of.ancestors(of.whole).find_map(|at| match of.kind(at) {
        ExprKind::Block(block) if block.kind == BlockKind::Async => {
            let is_move = of.written(at).trim_start_matches("async").trim_start().starts_with("move");
            Some((of.span(at), is_move))
        }
        ExprKind::Closure(closure) if closure.is_async => Some((of.span(at), closure.is_move)),
        _ => None,
    });
    future.is_some_and(|(span, is_move)| !is_move && !span.contains(local.span))
}

/// The type itself, if its values lie in the variable.
fn own_value(ty: &Ty) -> Option<&Ty> {
    (!matches!(ty, Ty::Ref(..)) && (held(ty).is_some() || matches!(ty, Ty::Adt(..)))).then_some(ty)
}

fn has_destructor(index: &Index, ty: &Ty) -> bool {
    let drops = TraitName::External("std::ops::Drop".to_owned());
    let own = held(ty).unwrap_or(ty);
    let is_it = |id: &crate::index::ImplId| index.impl_def(*id).implements.as_ref() == Some(&drops);
    index.impls_of(own).iter().any(is_it) || index.impls_of(ty).iter().any(is_it)
}
