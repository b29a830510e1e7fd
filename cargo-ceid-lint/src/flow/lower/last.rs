//! What is followed by nothing but the end of an iteration.

use rustc_hash::FxHashMap;

use crate::syntax::tree::{Block, Body, ExprId, ExprKind, StmtKind};

/// The expressions of a body that are the last ones of an iteration, at the end of a loop or of the function or right before a jump,
/// each with the values behind it that only name something: `drop(guard); Ok(level)`.
pub(super) fn last_of_iterations(body: &Body) -> FxHashMap<ExprId, Vec<ExprId>> {
    let mut found = FxHashMap::default();
    let mut open = vec![(body.root, Vec::new())];
    for expr in &body.exprs {
        match &expr.kind {
            ExprKind::Loop { body, .. } | ExprKind::While { body, .. } | ExprKind::For { body, .. } => {
                open.push((*body, Vec::new()));
            }
            ExprKind::Closure(code) => open.push((code.body, Vec::new())),
            ExprKind::Block(block) => open.extend(before_jumps(body, block)),
            _ => {}
        }
    }
    while let Some((id, behind)) = open.pop() {
        if found.contains_key(&id) {
            continue;
        }
        match &body.expr(id).kind {
            ExprKind::Block(block) => match block.tail {
                Some(tail) => {
                    let before = statements(block).last().flatten().filter(|_| is_named(body, tail));
                    open.extend(before.map(|before| (before, [&behind[..], &[tail]].concat())));
                    open.push((tail, behind.clone()));
                }
                None => open.extend(statements(block).last().flatten().map(|last| (last, behind.clone()))),
            },
            ExprKind::If { then, otherwise, .. } => {
                open.extend([*then].into_iter().chain(*otherwise).map(|branch| (branch, behind.clone())));
            }
            ExprKind::Match { arms, .. } => open.extend(arms.iter().map(|arm| (arm.body, behind.clone()))),
            _ => {}
        }
        found.insert(id, behind);
    }
    found
}

/// Whether a value is made of literals, names and fields, and nothing runs for it but `Ok(…)` and its kin.
fn is_named(body: &Body, id: ExprId) -> bool {
    let all = |parts: &[ExprId]| parts.iter().all(|part| is_named(body, *part));
    match &body.expr(id).kind {
        ExprKind::Literal(_) | ExprKind::Path(_) => true,
        ExprKind::Field { base: inner, .. }
        | ExprKind::Not(inner)
        | ExprKind::Negate(inner)
        | ExprKind::Cast { value: inner, .. }
        | ExprKind::Reference { value: inner, mutable: false, .. } => is_named(body, *inner),
        ExprKind::Tuple(parts) => all(parts),
        ExprKind::Binary { lhs, rhs, .. } => all(&[*lhs, *rhs]),
        ExprKind::Call { callee, args } => {
            let is_wrapper = |callee: &ExprKind| matches!(callee, ExprKind::Path(path) if matches!(path.last(), "Ok" | "Err" | "Some"));
            is_wrapper(&body.expr(*callee).kind) && all(args)
        }
        _ => false,
    }
}

/// The statements of a block that are expressions; `None` for the others.
fn statements(block: &Block) -> impl DoubleEndedIterator<Item = Option<ExprId>> + '_ {
    block.stmts.iter().map(|stmt| match stmt.kind {
        StmtKind::Expr { expr, .. } => Some(expr),
        StmtKind::Let { .. } => None,
    })
}

/// The statements of a block behind which control goes elsewhere, each with the value that goes with it.
fn before_jumps(body: &Body, block: &Block) -> Vec<(ExprId, Vec<ExprId>)> {
    let all: Vec<Option<ExprId>> = statements(block).chain(block.tail.map(Some)).collect();
    let given = |id: ExprId| match body.expr(id).kind {
        ExprKind::Continue { .. } => Some(Vec::new()),
        ExprKind::Break { value, .. } | ExprKind::Return(value) => {
            value.is_none_or(|value| is_named(body, value)).then(|| value.into_iter().collect())
        }
        _ => None,
    };
    all.windows(2).filter_map(|pair| Some((pair[0]?, given(pair[1]?)?))).collect()
}
