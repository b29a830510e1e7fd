//! Cells that are filled once, by whoever has them: `static CALIBRATION: OnceLock<f32>`. What is found there stays; where nothing was,
//! there may be something a moment later.

use crate::flow::lower::Builder;
use crate::flow::lower::parts::given_to;
use crate::flow::{Assignment, Effect, NodeId};
use crate::index::Ty;
use crate::syntax::tree::{ExprId, ExprKind};

impl Builder<'_> {
    /// Whether such a cell may be filled between two looks at it: by another thread, by another task, or by the function itself.
    pub(in crate::flow::lower) fn may_be_filled(&self, cell: ExprId) -> bool {
        let is_of_thread = match self.ty(cell).peel() {
            Ty::External(path, _) => path.ends_with("cell::OnceCell") || path.contains("unsync"),
            _ => false,
        };
        let waits = self.program.index.function(self.frames[self.frame].function).function.is_async;
        let fills = || {
            self.body().exprs.iter().any(|expr| match &expr.kind {
                ExprKind::MethodCall { receiver, method, .. } => {
                    matches!(method.as_str(), "set" | "get_or_init" | "try_insert" | "get_or_try_init" | "take")
                        && matches!(self.ty(*receiver).peel().external_name(), Some("OnceLock" | "OnceCell"))
                }
                _ => false,
            })
        };
        self.is_of_several(cell) && (!is_of_thread || waits) || fills()
    }

    /// Whether others may have a reference to what an expression names.
    fn is_of_several(&self, id: ExprId) -> bool {
        let ty = self.ty(id);
        let is_shared = matches!(ty, Ty::Ref(false, _)) || matches!(ty.peel().external_name(), Some("Rc" | "Arc"));
        is_shared
            || match &self.body().expr(id).kind {
                ExprKind::Path(_) => !self.typed().expr_local.contains_key(&id),
                ExprKind::Field { base, .. } | ExprKind::Index { base, .. } | ExprKind::Deref(base) => {
                    self.is_of_several(*base)
                }
                _ => true,
            }
    }

    /// Where one way behind a branch goes on: what was not there may be there from then on.
    pub(in crate::flow::lower) fn may_be_filled_behind(&mut self, branch: NodeId, way: NodeId, holds: bool) -> NodeId {
        let Effect::Branch(test) = &self.graph.node(branch).effect else { return way };
        let Some((id, cell)) = test.subject.and_then(|id| Some((id, self.graph.cells.filled.get(&id)?.clone()))) else {
            return way;
        };
        let heads = if holds { test.holds } else { test.fails };
        if heads & self.graph.subjects[id.0 as usize].bit("+") != 0 {
            return way;
        }
        let span = self.graph.node(branch).span;
        let filled = Assignment { rebinds: false, ..given_to(cell, None) };
        let after = self.add_node(Effect::Write(Box::new(filled)), span);
        self.link(way, after);
        after
    }
}
