//! Methods that tell what a filter is set to, and nothing of what went through it: `eq.response(frequency)`.

use crate::flow::Program;
use crate::flow::lower::resets::state_fields;
use crate::index::{FunctionId, Ty};
use crate::syntax::tree::{Body, Expr, ExprId, ExprKind, Pat, PatKind, Receiver};
use crate::types::Callee;

/// How deep calls are followed.
const MAX_DEPTH: u32 = 4;

/// Whether a method works something out of the fields of its filter that no law writes. One that only hands out a field is asked for
/// what the filter was given, and does not count.
pub fn works_out_of_settings(program: &Program<'_>, method: FunctionId) -> bool {
    let function = &program.index.function(method).function;
    let Some(body) = function.body.as_ref().filter(|_| function.receiver == Some(Receiver::Shared)) else {
        return false;
    };
    let hands_out = matches!(body.expr(tail(body, body.root)).kind, ExprKind::Field { .. } | ExprKind::Path(_));
    !hands_out && reads_settings(program, method, 0)
}

/// What a body gives, where it does nothing before.
fn tail(body: &Body, id: ExprId) -> ExprId {
    match &body.expr(id).kind {
        ExprKind::Block(block) if block.stmts.is_empty() => block.tail.map_or(id, |inner| tail(body, inner)),
        ExprKind::Reference { value: inner, .. } | ExprKind::Deref(inner) | ExprKind::Index { base: inner, .. } => {
            tail(body, *inner)
        }
        ExprKind::MethodCall { receiver, method, .. } if matches!(method.as_str(), "clone" | "as_ref" | "to_owned") => {
            tail(body, *receiver)
        }
        _ => id,
    }
}

/// Whether code reads no state of a filter: no field that a law writes, and no filter as a whole.
fn reads_settings(program: &Program<'_>, id: FunctionId, depth: u32) -> bool {
    let index = program.index;
    let Some(body) = index.function(id).function.body.as_ref().filter(|_| depth < MAX_DEPTH) else { return false };
    let Some(typed) = program.typed(id) else { return false };
    let ty = |id: &ExprId| typed.ty(*id).peel();
    let is_filter = |id: &ExprId| index.filter_spec(ty(id)).is_some();
    let follows = |call: ExprId| {
        let targets = match typed.callees.get(&call) {
            Some(Callee::Resolved(resolved)) => resolved.targets.as_slice(),
            _ => &[],
        };
        !targets.is_empty() && targets.iter().all(|target| reads_settings(program, *target, depth + 1))
    };
    let exprs = (0u32..).map(ExprId).zip(&body.exprs);
    let is_read = |(id, expr): (ExprId, &Expr)| match &expr.kind {
        ExprKind::Field { base, name } => is_state_field(program, ty(base), name),
        ExprKind::MethodCall { receiver, args, .. } => {
            (is_filter(receiver) || args.iter().any(is_filter)) && !follows(id)
        }
        ExprKind::Call { args, .. } => args.iter().any(is_filter) && !follows(id),
        ExprKind::Opaque(_) | ExprKind::Unknown { .. } => true,
        _ => false,
    };
    let is_taken_apart = |pat: &Pat| match &pat.kind {
        PatKind::Struct(_, fields) => fields.iter().any(|(name, _)| {
            body.exprs.iter().zip(0u32..).any(|(_, id)| is_state_field(program, ty(&ExprId(id)), name))
        }),
        _ => false,
    };
    !is_filter(&tail(body, body.root)) && !exprs.into_iter().any(is_read) && !body.pats.iter().any(is_taken_apart)
}

/// Whether a field of a filter is written by its laws, as far as these can be seen. What is a filter itself is asked by its own fields.
pub fn is_state_field(program: &Program<'_>, ty: &Ty, field: &str) -> bool {
    if program.index.receiver_spec(ty).is_none() {
        return program.index.filter_spec(ty).is_some();
    }
    let is_part = program.index.field_ty(ty, None, field).is_some_and(|ty| program.index.holds_filter(&ty));
    let state = state_fields(program, ty);
    !is_part && (state.is_empty() || state.contains(field))
}
