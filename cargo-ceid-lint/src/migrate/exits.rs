//! The ways out of a loop from within an iteration: on each of them a guard runs the laws as well. One of them is an `.await` from
//! which the program does not come back.

use super::body::LoopBody;
use super::sites::{Part, sites};
use crate::count::{Gate, Pair, Verdict};
use crate::syntax::tree::{BlockKind, ExprId, ExprKind, MacroKind, Stmt, StmtKind};

/// The expressions at which an iteration may leave the loop, and those of which nothing is known.
#[derive(Debug, Default)]
pub(super) struct Exits {
    /// `break`, `return`, `?`, a `continue` of a loop around it.
    pub(super) left_at: Vec<ExprId>,
    /// Where the iteration waits, and is left for ever if nobody goes on waiting for it.
    pub(super) waits: Vec<ExprId>,
    /// Code that is not read, and may do anything.
    pub(super) unread: Vec<ExprId>,
}

/// The ways out of the loop.
pub(super) fn exits(of: &LoopBody<'_>) -> Exits {
    let mut exits = Exits::default();
    for id in &of.inside {
        match of.kind(*id) {
            ExprKind::Break { label, .. } if leaves(of, *id, label.as_ref(), true) => exits.left_at.push(*id),
            ExprKind::Continue { label } if leaves(of, *id, label.as_ref(), false) => exits.left_at.push(*id),
            ExprKind::Return(_) | ExprKind::Try(_) if !is_in_closure(of, *id) => exits.left_at.push(*id),
            ExprKind::Await(_) if !is_in_closure(of, *id) => exits.waits.push(*id),
            ExprKind::Macro(call) => match call.kind {
                MacroKind::Select(_) | MacroKind::Join { fallible: false, .. } => exits.waits.push(*id),
                MacroKind::ReturnsErr(_) | MacroKind::Ensure(..) if !is_in_closure(of, *id) => exits.left_at.push(*id),
                MacroKind::Join { fallible: true, .. } => exits.left_at.push(*id),
                _ => {}
            },
            ExprKind::Opaque(_) | ExprKind::Unknown { .. } => exits.unread.push(*id),
            _ => {}
        }
    }
    exits.left_at.sort_by_key(|id| of.span(*id));
    exits.waits.sort_by_key(|id| of.span(*id));
    exits
}

/// Whether a filter is updated once wherever its update is come to. Some calls of a function may end before that, which are left to do
/// so above its guard.
pub(super) fn is_exact(of: &LoopBody<'_>, pair: &Pair) -> bool {
    matches!(pair.verdict, Verdict::Once | Verdict::PerSample) || ends_before(of, pair)
}

/// Whether a function does not update a filter only where it has returned above that. A cycle of a slower rate has a clock of its own,
/// and is none of these.
pub(super) fn ends_before(of: &LoopBody<'_>, pair: &Pair) -> bool {
    let is_apart = matches!(pair.gate, Some(Gate::Config | Gate::Sample | Gate::Event));
    if !(of.is_function && pair.verdict == Verdict::Gated && pair.counts == [0, 1] && is_apart) {
        return false;
    }
    let (Ok(sites), ExprKind::Block(whole)) = (sites(of, pair), of.kind(of.block)) else { return false };
    let [site] = sites.as_slice() else { return false };
    site.part == Part::Whole && of.statement(site.outer).is_some_and(|(block, _)| std::ptr::eq(block, whole))
}

/// Whether `break` or `continue` goes further than the end of this iteration.
fn leaves(of: &LoopBody<'_>, id: ExprId, label: Option<&String>, is_break: bool) -> bool {
    let is_target = |at: &ExprId| match of.kind(*at) {
        ExprKind::Loop { label: own, .. } | ExprKind::While { label: own, .. } | ExprKind::For { label: own, .. } => {
            label.is_none() || own.as_ref() == label
        }
        ExprKind::Macro(call) => matches!(call.kind, MacroKind::EachCycle { .. }) && label.is_none(),
        ExprKind::Block(block) => label.is_some() && block.label.as_ref() == label,
        _ => false,
    };
    match of.ancestors(id).find(is_target) {
        Some(target) if target == of.whole => is_break,
        Some(target) => !of.inside.contains(&target),
        None => true,
    }
}

/// Whether an expression always goes on to the next iteration or leaves the loop, and never to what follows it.
pub(super) fn diverges(of: &LoopBody<'_>, id: ExprId) -> bool {
    match of.kind(id) {
        ExprKind::Return(_) => true,
        ExprKind::Break { label, .. } | ExprKind::Continue { label } => leaves(of, id, label.as_ref(), true),
        ExprKind::If { then, otherwise: Some(otherwise), .. } => diverges(of, *then) && diverges(of, *otherwise),
        ExprKind::Block(block) if block.label.is_none() && block.kind == BlockKind::Plain => {
            let of_stmt = |stmt: &Stmt| matches!(stmt.kind, StmtKind::Expr { expr, .. } if diverges(of, expr));
            block.stmts.iter().any(of_stmt) || block.tail.is_some_and(|tail| diverges(of, tail))
        }
        _ => false,
    }
}

/// Whether a closure or an `async` block of the iteration is what is left.
fn is_in_closure(of: &LoopBody<'_>, id: ExprId) -> bool {
    of.ancestors_inside(id).any(|at| match of.kind(at) {
        ExprKind::Closure(_) => true,
        ExprKind::Block(block) => matches!(block.kind, BlockKind::Async | BlockKind::Try),
        _ => false,
    })
}
