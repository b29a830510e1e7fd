//! Closures before edition 2021: they take all of a variable, also where they name only one of its fields.

use super::Reason;
use super::body::LoopBody;
use super::mentions::{Guarded, is_about};
use crate::syntax::tree::{BlockKind, ExprId, ExprKind};

/// The closures that would take the owner of a field while a guard holds that field.
pub(super) fn captures(of: &LoopBody<'_>, guarded: &[Guarded]) -> Vec<Reason> {
    guarded.iter().filter(|own| !own.place.fields.is_empty()).filter_map(|own| capture(of, own)).collect()
}

fn capture(of: &LoopBody<'_>, own: &Guarded) -> Option<Reason> {
    // What is lent above the loop is lent in its head as well.
    let around = if own.is_lent_above() && !of.is_function { of.loop_statement() } else { of.block };
    let is_closure = |at: ExprId| match of.kind(at) {
        ExprKind::Closure(_) => true,
        ExprKind::Block(block) => block.kind == BlockKind::Async,
        _ => false,
    };
    let is_of_another_field =
        |id: &ExprId| of.typed.expr_local.get(id) == Some(&own.place.local) && !is_about(of, &own.place, *id);
    let mut named = of.body.within(around).filter(is_of_another_field);
    let id = named.find(|id| of.ancestors(*id).take_while(|at| *at != around).any(is_closure))?;
    let local = &of.typed.local(own.place.local).name;
    let Some(ExprKind::Field { name: field, .. }) = of.parent(id).map(|parent| of.kind(parent)) else { return None };
    let text = format!(
        "before edition 2021 a closure takes all of `{local}`, of which the guard holds `{}`: give it `{local}.{field}` under a name of \
         its own, as in `let {field} = &{local}.{field};`, or run `cargo fix --edition`",
        own.spelled
    );
    Some(Reason { span: of.span(id), text })
}
