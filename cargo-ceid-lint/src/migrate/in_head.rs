//! What the head of a loop asks of a filter that is lent above it.

use super::Reason;
use super::body::LoopBody;
use super::mentions::{Guarded, is_about, is_about_owner};
use super::owned::is_owned;
use super::shadowed::is_shadowed;
use crate::syntax::tree::{ExprId, ExprKind};

/// What stands around the loop in its statement, its head included, runs while the filter is lent, and may not name it; but the
/// condition of a `while` runs where the guard is gone, and may name what lends the filter.
///
/// Gives the places in that condition.
pub(super) fn named_in_head(of: &LoopBody<'_>, own: &Guarded) -> Result<Vec<ExprId>, Reason> {
    if of.is_function {
        return Ok(Vec::new());
    }
    let is_outside = |id: &ExprId| !of.inside.contains(id);
    let is_named = |id: &ExprId| {
        let local = of.typed.local(own.place.local);
        if let ExprKind::Opaque(call) = of.kind(*id) {
            return call.mentions.contains(&local.name);
        }
        is_about(of, &own.place, *id)
    };
    let mut places = Vec::new();
    for id in of.body.within(of.loop_statement()).filter(is_outside).filter(is_named) {
        match lookup(of, own, id) {
            Some(place) => places.push(place),
            None => {
                let text = if is_about_owner(of, &own.place, id) {
                    format!(
                        "all of `{}` is used in the head of the loop, where `{}` is lent to the guard: use only the fields that are \
                         needed there",
                        of.written(id),
                        own.spelled
                    )
                } else {
                    let what = if own.place.element.is_some() { of.written(id) } else { &own.spelled };
                    let advice = match of.kind(of.whole) {
                        ExprKind::While { .. } => {
                            ": write `loop`, and `break` at its beginning where the condition does not hold"
                        }
                        _ => "",
                    };
                    format!("`{what}` is used in the head of the loop, where it is lent to the guard{advice}")
                };
                return Err(Reason { span: of.span(id), text });
            }
        }
    }
    Ok(places)
}

/// The place in the condition of a `while` that a name leads to, if only a field or method of it is asked for.
fn lookup(of: &LoopBody<'_>, own: &Guarded, id: ExprId) -> Option<ExprId> {
    let ExprKind::While { condition, .. } = of.kind(of.whole) else { return None };
    let in_condition: Vec<ExprId> = of.body.within(*condition).collect();
    let index = of.program.index;
    let scope = index.scope_of(of.function);
    let lends_on = |id: &ExprId| match of.kind(*id) {
        // What a pattern takes apart is there in the iteration, too.
        ExprKind::Let { value, .. } => !is_owned(index, &scope, of.typed.ty(*value)),
        ExprKind::Closure(_) | ExprKind::Macro(_) => true,
        _ => false,
    };
    if !in_condition.contains(&id) || in_condition.iter().any(lends_on) || own.place.element.is_some() {
        return None;
    }
    let place = own.place.fields.iter().try_fold(id, |at, _| of.parent(at))?;
    let is_asked = match of.kind(of.parent(place)?) {
        ExprKind::Field { .. } => true,
        ExprKind::MethodCall { receiver, method, .. } => {
            *receiver == place && !is_shadowed(of, place) && !matches!(method.as_str(), "feed" | "last_output")
        }
        _ => false,
    };
    (is_asked && of.written(place) == own.spelled).then_some(place)
}
