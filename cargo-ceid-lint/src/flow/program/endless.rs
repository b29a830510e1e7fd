//! Functions that never come back, whatever they are declared to give: `fn die() { std::process::exit(3); }`.

use rustc_hash::FxHashSet;

use crate::index::{FunctionId, Index, Ty};
use crate::syntax::tree::{BlockKind, Body, ExprId, ExprKind, Literal, MacroKind, StmtKind, TypeRef};
use crate::types::{Callee, Resolved, TypedBody};

/// How often it is asked again which functions call those that are found.
const MAX_ROUNDS: usize = 4;

/// The functions in which no way leads to the end.
pub(super) fn endless(index: &Index, bodies: &[Option<TypedBody>]) -> FxHashSet<FunctionId> {
    let typed = |id: FunctionId| bodies.get(id.0 as usize).and_then(Option::as_ref);
    let mut open: Vec<(FunctionId, &Body, &TypedBody)> = index
        .function_ids()
        .filter(|id| !index.function(*id).function.is_async)
        .filter_map(|id| Some((id, index.function(id).function.body.as_ref()?, typed(id)?)))
        .filter(|(_, body, _)| !body.exprs.is_empty() && !may_leave(body))
        .collect();
    let mut found = FxHashSet::default();
    for _ in 0..MAX_ROUNDS {
        let before = found.len();
        open.retain(|(id, body, typed)| {
            let ends = Code { index, body, typed, endless: &found }.ends(body.root);
            if ends {
                found.insert(*id);
            }
            !ends
        });
        if found.len() == before {
            break;
        }
    }
    found
}

/// Whether a function of another crate ends the program or the thread, or starts the device anew.
#[must_use]
pub(in crate::flow) fn is_exit(path: &str) -> bool {
    matches!(
        path,
        "std::process::exit"
            | "std::process::abort"
            | "std::panic::panic_any"
            | "std::panic::resume_unwind"
            | "std::hint::unreachable_unchecked"
    )
}

/// Whether a call runs one of these functions, whoever implements what.
pub(in crate::flow) fn runs_endless(index: &Index, endless: &FxHashSet<FunctionId>, resolved: &Resolved) -> bool {
    let is_chosen = resolved.owner.as_ref().is_some_and(|owner| owner.of_trait().is_some())
        && !matches!(resolved.self_ty.peel(), Ty::Adt(..));
    matches!(resolved.targets.as_slice(), [target] if !is_chosen && endless.contains(&index.origin(*target)))
}

/// Whether something in a body may leave it before its end.
fn may_leave(body: &Body) -> bool {
    body.exprs.iter().any(|expr| match &expr.kind {
        ExprKind::Return(_) | ExprKind::Try(_) => true,
        ExprKind::Macro(call) => matches!(call.kind, MacroKind::ReturnsErr(_) | MacroKind::Ensure(..)),
        ExprKind::Opaque(call) => !call.ways_out.is_empty(),
        _ => false,
    })
}

struct Code<'a> {
    index: &'a Index,
    body: &'a Body,
    typed: &'a TypedBody,
    endless: &'a FxHashSet<FunctionId>,
}

impl Code<'_> {
    /// Whether no way leads behind an expression.
    fn ends(&self, id: ExprId) -> bool {
        let ends = |id: &ExprId| self.ends(*id);
        match &self.body.expr(id).kind {
            ExprKind::Closure(_) | ExprKind::Await(_) | ExprKind::Opaque(_) | ExprKind::Unknown { .. } => false,
            ExprKind::Block(block) => {
                let is_here = matches!(block.kind, BlockKind::Plain | BlockKind::Unsafe);
                let is_left = || block.label.is_some() && self.is_left(id, true);
                let stmts = block.stmts.iter().filter(|stmt| stmt.cfg.is_none());
                let of_stmts = stmts.filter_map(|stmt| match stmt.kind {
                    StmtKind::Let { init, .. } => init,
                    StmtKind::Expr { expr, .. } => Some(expr),
                });
                is_here && of_stmts.chain(block.tail).any(|id| self.ends(id)) && !is_left()
            }
            ExprKind::If { condition, then, otherwise } => {
                self.ends(*condition) || self.ends(*then) && otherwise.as_ref().is_some_and(ends)
            }
            ExprKind::Match { scrutinee, arms } => {
                self.ends(*scrutinee) || !arms.is_empty() && arms.iter().all(|arm| self.ends(arm.body))
            }
            ExprKind::Loop { body, .. } => !self.is_left(*body, false),
            ExprKind::While { condition, body, .. } => {
                let is_always = matches!(self.body.expr(*condition).kind, ExprKind::Literal(Literal::Bool(true)));
                self.ends(*condition) || is_always && !self.is_left(*body, false)
            }
            ExprKind::For { iterable, .. } => self.ends(*iterable),
            ExprKind::Binary { op: "&&" | "||", lhs, .. } => self.ends(*lhs),
            ExprKind::Call { .. } | ExprKind::MethodCall { .. } => {
                let never = match self.typed.callees.get(&id) {
                    Some(Callee::External(path)) => is_exit(path),
                    Some(Callee::Resolved(resolved)) => {
                        let is_never = |target: &FunctionId| {
                            let function = &self.index.function(*target).function;
                            function.output == TypeRef::Never && !function.is_async
                        };
                        !resolved.targets.is_empty() && resolved.targets.iter().all(is_never)
                            || runs_endless(self.index, self.endless, resolved)
                    }
                    _ => false,
                };
                never || self.body.children(id).iter().any(ends)
            }
            ExprKind::Macro(call) => match &call.kind {
                // What is still to be written will come back.
                MacroKind::Diverges(_) => !matches!(call.path.rsplit("::").next(), Some("todo" | "unimplemented")),
                MacroKind::All(operands) => operands.iter().any(ends),
                MacroKind::Assert(condition, _) => self.ends(*condition),
                MacroKind::AssertCompare(left, right, _) => self.ends(*left) || self.ends(*right),
                _ => false,
            },
            _ => self.body.children(id).iter().any(ends),
        }
    }

    /// Whether a `break` may lead out of a loop or a block with a label.
    fn is_left(&self, id: ExprId, by_label: bool) -> bool {
        match &self.body.expr(id).kind {
            ExprKind::Break { label, .. } => label.is_some() || !by_label,
            ExprKind::Continue { label } => label.is_some(),
            ExprKind::Closure(_) => false,
            ExprKind::Opaque(_) | ExprKind::Unknown { .. } => true,
            ExprKind::Loop { .. } | ExprKind::While { .. } | ExprKind::For { .. } => {
                self.body.children(id).into_iter().any(|id| self.is_left(id, true))
            }
            _ => self.body.children(id).into_iter().any(|id| self.is_left(id, by_label)),
        }
    }
}
