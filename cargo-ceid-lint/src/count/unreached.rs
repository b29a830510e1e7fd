//! Code that no way leads to: what stands behind a call that never comes back, or under a `return`.

use crate::flow::{ControlFlowGraph, Program, Var};
use crate::source::Span;
use crate::syntax::tree::ExprKind;

/// Whether a loop that speaks of a variable is never reached, so that nothing is known of what would become of the variable.
pub(super) fn is_in_unreached_loop(program: &Program<'_>, graph: &ControlFlowGraph, var: Var) -> bool {
    let Some(body) = &program.index.function(graph.function).function.body else { return false };
    let name = &graph.var(var).name;
    let is_reached = |keyword: Span| {
        graph.loops.iter().any(|info| info.keyword == keyword)
            || graph.written_out.iter().any(|(written, _)| *written == keyword)
    };
    let loops = body.exprs.iter().filter(|expr| match &expr.kind {
        ExprKind::Loop { keyword, .. } | ExprKind::While { keyword, .. } | ExprKind::For { keyword, .. } => {
            !is_reached(*keyword)
        }
        _ => false,
    });
    let is_it = |kind: &ExprKind| matches!(kind, ExprKind::Path(path) if path.ident() == Some(name.as_str()));
    loops
        .into_iter()
        .any(|unreached| body.exprs.iter().any(|expr| unreached.span.contains(expr.span) && is_it(&expr.kind)))
}
