//! Updates by hand that no verdict counts, because the program that is shipped does not run them: a guard would run the law beside
//! them.

use super::Reason;
use super::body::LoopBody;
use super::mentions::Guarded;
use super::sites::place_of;
use crate::count::Cycle;
use crate::syntax::tree::{ExprId, ExprKind};
use crate::types::Callee;

/// The first call of the law of a filter that goes to the guard, where the cycle does not count it.
pub(super) fn not_shipped(of: &LoopBody<'_>, cycle: &Cycle, guarded: &[Guarded]) -> Option<Reason> {
    let is_law =
        |id: &ExprId| matches!(of.typed.callees.get(id), Some(Callee::Resolved(callee)) if callee.law.is_some());
    let is_counted = |id: &ExprId| {
        let span = of.span(*id);
        cycle.filters.iter().any(|pair| pair.updates.contains(&span))
            || guarded.iter().any(|own| own.sites.iter().any(|site| site.call == *id))
    };
    let uncounted = of.inside.iter().filter(|id| is_law(id) && !is_counted(id));
    uncounted.copied().find_map(|id| {
        let own = guarded.iter().find(|own| receiver(of, id).is_some_and(|at| is_at(of, own, at)))?;
        let text = format!(
            "no build that is shipped runs this update of `{}`, and those that do would run it beside the guard: take it away first",
            own.spelled
        );
        Some(Reason { span: of.span(id), text })
    })
}

fn receiver(of: &LoopBody<'_>, call: ExprId) -> Option<ExprId> {
    let mut at = match of.kind(call) {
        ExprKind::MethodCall { receiver, .. } => *receiver,
        ExprKind::Call { args, .. } => *args.first()?,
        _ => return None,
    };
    while let ExprKind::Reference { value: inner, .. } | ExprKind::Index { base: inner, .. } | ExprKind::Deref(inner) =
        of.kind(at)
    {
        at = *inner;
    }
    Some(at)
}

fn is_at(of: &LoopBody<'_>, own: &Guarded, at: ExprId) -> bool {
    place_of(of, at).is_some_and(|place| place.local == own.place.local && place.fields == own.place.fields)
}
