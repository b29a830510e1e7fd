//! What is followed by nothing but the end of an iteration.

use rustc_hash::FxHashSet;

use crate::syntax::tree::{Block, Body, ExprId, ExprKind, StmtKind};

/// The expressions of a body that are the last ones of an iteration: at the end of a loop or of the function, or right before
/// a jump.
pub(super) fn last_of_iterations(body: &Body) -> FxHashSet<ExprId> {
    let mut found = FxHashSet::default();
    let mut open = vec![body.root];
    for expr in &body.exprs {
        match &expr.kind {
            ExprKind::Loop { body, .. } | ExprKind::While { body, .. } | ExprKind::For { body, .. } => open.push(*body),
            ExprKind::Closure(code) => open.push(code.body),
            ExprKind::Block(block) => open.extend(before_jumps(body, block)),
            _ => {}
        }
    }
    while let Some(id) = open.pop() {
        if !found.insert(id) {
            continue;
        }
        match &body.expr(id).kind {
            ExprKind::Block(block) => open.extend(block.tail.or_else(|| statements(block).last()?)),
            ExprKind::If { then, otherwise, .. } => open.extend([*then].into_iter().chain(*otherwise)),
            ExprKind::Match { arms, .. } => open.extend(arms.iter().map(|arm| arm.body)),
            _ => {}
        }
    }
    found
}

/// The statements of a block that are expressions; `None` for the others.
fn statements(block: &Block) -> impl DoubleEndedIterator<Item = Option<ExprId>> + '_ {
    block.stmts.iter().map(|stmt| match stmt.kind {
        StmtKind::Expr { expr, .. } => Some(expr),
        StmtKind::Let { .. } => None,
    })
}

/// The statements of a block behind which control goes elsewhere.
fn before_jumps(body: &Body, block: &Block) -> Vec<ExprId> {
    let all: Vec<Option<ExprId>> = statements(block).chain(block.tail.map(Some)).collect();
    let is_jump = |id: ExprId| {
        matches!(
            body.expr(id).kind,
            ExprKind::Continue { .. } | ExprKind::Break { value: None, .. } | ExprKind::Return(None)
        )
    };
    all.windows(2).filter(|pair| pair[1].is_some_and(is_jump)).filter_map(|pair| pair[0]).collect()
}
