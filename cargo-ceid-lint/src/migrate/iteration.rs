//! What an inner loop runs over: which elements of which collection its variables are, and whether it gives each of them.

use super::body::LoopBody;
use super::sites::{Part, Place, place_of};
use crate::index::Ty;
use crate::syntax::tree::{ExprId, ExprKind, Literal, PatId, PatKind};
use crate::types::{Callee, LocalId};

/// A collection whose elements, or their numbers, an inner loop gives one after the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Elements {
    /// The loop.
    pub(super) inner: ExprId,
    /// The collection; none for numbers.
    pub(super) collection: Option<ExprId>,
    /// Whether the loop goes on to the last element, whatever else it runs over.
    pub(super) is_each: bool,
}

/// What runs its body for each item: a `for`, or `for_each` with a closure.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inner {
    /// What gives the items.
    pub(super) iterable: ExprId,
    /// What they are called.
    pub(super) pat: PatId,
    /// What runs.
    pub(super) body: ExprId,
}

/// The inner loop that an expression is.
pub(super) fn inner_loop(of: &LoopBody<'_>, id: ExprId) -> Option<Inner> {
    match of.kind(id) {
        ExprKind::For { iterable, pat, body, .. } => Some(Inner { iterable: *iterable, pat: *pat, body: *body }),
        ExprKind::MethodCall { receiver, method, args, .. } if method == "for_each" => {
            let [closure] = args.as_slice() else { return None };
            let ExprKind::Closure(closure) = of.kind(*closure) else { return None };
            let [(pat, _)] = closure.params.as_slice() else { return None };
            let is_plain = !closure.is_move && !closure.is_async;
            is_plain.then_some(Inner { iterable: *receiver, pat: *pat, body: closure.body })
        }
        _ => None,
    }
}

/// Whether an expression is what a closure gives back that `for_each` calls: nothing uses it.
pub(super) fn is_closure_of_a_loop(of: &LoopBody<'_>, id: ExprId) -> bool {
    let call = of.parent(id).and_then(|closure| of.parent(closure));
    let is_closure = of.parent(id).is_some_and(|closure| matches!(of.kind(closure), ExprKind::Closure(_)));
    is_closure && call.and_then(|call| inner_loop(of, call)).is_some_and(|inner| inner.body == id)
}

/// The inner loop that gives a variable an element to change, or the number of one.
pub(super) fn elements(of: &LoopBody<'_>, id: ExprId, local: LocalId) -> Option<Elements> {
    let inner = binding_loop(of, id, local)?;
    let Inner { iterable, pat, .. } = inner_loop(of, inner)?;
    let (collection, is_each) = given(of, iterable, pat, local)?;
    Some(Elements { inner, collection, is_each })
}

/// The place that a receiver means in loops that do nothing but update all that they run over, with the outermost of these: the rows of
/// an array, or a list of places, of which the filter has this name.
pub(super) fn all_at_once(
    of: &LoopBody<'_>,
    receiver: ExprId,
    update: ExprId,
    name: &str,
) -> Option<(Place, Part, ExprId, Option<ExprId>)> {
    let local = *of.typed.expr_local.get(&receiver)?;
    if let Some((collection, outer)) = rows(of, receiver, local, update) {
        return Some((place_of(of, collection)?, Part::All, collection, Some(outer)));
    }
    let inner = binding_loop(of, receiver, local).filter(|inner| is_lone(of, *inner, update))?;
    let own = listed(of, inner)?.into_iter().find(|own| of.written(*own) == name)?;
    Some((place_of(of, own)?, Part::Whole, own, Some(inner)))
}

/// The places of filters that an inner loop lists: `for axis in [&mut roll, &mut self.pitch]`.
pub(super) fn listed(of: &LoopBody<'_>, inner: ExprId) -> Option<Vec<ExprId>> {
    let Inner { iterable, pat, .. } = inner_loop(of, inner)?;
    let ExprKind::Array { elements, .. } = of.kind(iterable) else { return None };
    let place = |element: &ExprId| match of.kind(*element) {
        ExprKind::Reference { mutable: true, raw: false, value } => Some(*value),
        _ => None,
    };
    let is_filter = |own: &ExprId| matches!(of.typed.ty(*own), Ty::Adt(..)) && place_of(of, *own).is_some();
    let places: Vec<ExprId> = elements.iter().map(place).collect::<Option<_>>()?;
    (of.typed.pat_local.contains_key(&pat) && places.iter().all(is_filter)).then_some(places)
}

/// The collection of rows of which a variable is an element of each, and the loop over the rows, where the loops from that one on do
/// nothing but reach the update: `for row in &mut self.keys { for key in row { key.update(); } }`.
fn rows(of: &LoopBody<'_>, id: ExprId, local: LocalId, update: ExprId) -> Option<(ExprId, ExprId)> {
    let inner = binding_loop(of, id, local)?;
    let Inner { iterable, .. } = inner_loop(of, inner)?;
    let row = match of.kind(iterable) {
        ExprKind::MethodCall { receiver, method, args, .. } if method == "iter_mut" && args.is_empty() => *receiver,
        _ => iterable,
    };
    let is_row = matches!(of.typed.ty(row), Ty::Ref(true, row) if matches!(**row, Ty::Array(..)));
    let row = of.typed.expr_local.get(&row).copied().filter(|_| is_row && is_lone(of, inner, update))?;
    // The row may be one of rows itself.
    rows(of, inner, row, inner).or_else(|| {
        let elements = elements(of, inner, row).filter(|elements| elements.is_each)?;
        is_lone(of, elements.inner, inner).then_some((elements.collection?, elements.inner))
    })
}

/// Whether an inner loop does nothing but run one expression: to update its element.
pub(super) fn is_lone(of: &LoopBody<'_>, inner: ExprId, update: ExprId) -> bool {
    let Some(Inner { body, .. }) = inner_loop(of, inner) else { return false };
    let ExprKind::Block(block) = of.kind(body) else { return body == update };
    let is_whole = of.statement(update).is_some_and(|(around, _)| std::ptr::eq(around, block));
    let is_alone = block.stmts.len() + usize::from(block.tail.is_some()) == 1 && block.items.is_empty();
    is_whole && is_alone
}

/// The inner loop whose pattern binds a variable.
pub(super) fn binding_loop(of: &LoopBody<'_>, id: ExprId, local: LocalId) -> Option<ExprId> {
    of.ancestors_inside(id).find(|at| inner_loop(of, *at).is_some_and(|inner| binds(of, inner.pat, local)))
}

/// Whether a pattern of names and tuples binds a variable.
pub(super) fn binds(of: &LoopBody<'_>, pat: PatId, local: LocalId) -> bool {
    match &of.body.pat(pat).kind {
        PatKind::Tuple(parts) => parts.iter().any(|part| binds(of, *part, local)),
        _ => of.typed.pat_local.get(&pat) == Some(&local),
    }
}

/// The collection of which a variable of the pattern is an element, and whether it is each of them in turn.
fn given(of: &LoopBody<'_>, iterable: ExprId, pat: PatId, local: LocalId) -> Option<(Option<ExprId>, bool)> {
    let parts: &[PatId] = match &of.body.pat(pat).kind {
        PatKind::Tuple(parts) => parts,
        PatKind::Bind { by_ref: false, sub: None, .. } if binds(of, pat, local) => &[],
        _ => return None,
    };
    match (of.kind(iterable), parts) {
        (ExprKind::Reference { mutable: true, raw: false, value }, []) => {
            let value = if let ExprKind::Deref(held) = of.kind(*value) { held } else { value };
            Some((Some(*value), true))
        }
        (ExprKind::MethodCall { receiver, method, args, .. }, []) if method == "iter_mut" && args.is_empty() => {
            Some((Some(*receiver), true))
        }
        (ExprKind::Range { .. }, []) => Some((None, true)),
        (ExprKind::MethodCall { receiver, method, args, .. }, _) if method == "rev" && args.is_empty() => {
            given(of, *receiver, pat, local)
        }
        (ExprKind::MethodCall { receiver, method, args, .. }, [number, item])
            if method == "enumerate" && args.is_empty() =>
        {
            if binds(of, *number, local) {
                // As many as the other collection has.
                return Some((None, false));
            }
            given(of, *receiver, *item, local)
        }
        (_, [first, second]) => {
            let (one, other) = zipped(of, iterable)?;
            let is_first = binds(of, *first, local);
            let (own, beside) = if is_first { (one, other) } else { (other, one) };
            let (collection, is_each) = given(of, own, if is_first { *first } else { *second }, local)?;
            let is_longer = length(of, own).zip(length(of, beside)).is_some_and(|(own, beside)| beside >= own);
            Some((collection, is_each && is_longer))
        }
        _ => None,
    }
}

/// The two iterators that run side by side.
pub(super) fn zipped(of: &LoopBody<'_>, id: ExprId) -> Option<(ExprId, ExprId)> {
    match (of.kind(id), of.typed.callees.get(&id)) {
        (ExprKind::MethodCall { receiver, method, args, .. }, _) if method == "zip" => match args.as_slice() {
            [other] => Some((*receiver, *other)),
            _ => None,
        },
        (ExprKind::Call { args, .. }, Some(Callee::External(path))) if path == "std::iter::zip" => {
            match args.as_slice() {
                [one, other] => Some((*one, *other)),
                _ => None,
            }
        }
        _ => None,
    }
}

/// How many items an iterator has, if its type or its form tells; without an end, the most there can be.
fn length(of: &LoopBody<'_>, id: ExprId) -> Option<u64> {
    match of.kind(id) {
        ExprKind::MethodCall { receiver, method, args, .. } => match (method.as_str(), args.as_slice()) {
            ("iter" | "iter_mut" | "into_iter" | "enumerate" | "rev" | "copied" | "cloned", []) => {
                length(of, *receiver)
            }
            _ => None,
        },
        ExprKind::Range { start, end, inclusive } => {
            let number = |id: &ExprId| match of.kind(*id) {
                ExprKind::Literal(Literal::Int(number, _)) => *number,
                _ => None,
            };
            match (start, end) {
                (Some(_), None) => Some(u64::MAX),
                (Some(start), Some(end)) => {
                    number(end)?.checked_sub(number(start)?)?.checked_add(u64::from(*inclusive))
                }
                _ => None,
            }
        }
        _ => match of.typed.ty(id).peel() {
            Ty::Array(_, length) => length.value,
            _ => None,
        },
    }
}
