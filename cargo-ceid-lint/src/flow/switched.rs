//! Cells that other code than a function's own writes, as another task does while the function waits.

use std::collections::BTreeSet;

use super::{Flag, Program};
use crate::index::{Def, FunctionId};
use crate::syntax::tree::{Body, ExprId, ExprKind};
use crate::types::Callee;

impl Program<'_> {
    /// Whether a function that the given one does not call may write a cell.
    #[must_use]
    pub fn is_written_by_others(&self, cell: Flag<'_>, own: FunctionId) -> bool {
        let called = self.called_from(own);
        self.index.function_ids().filter(|id| !called.contains(id)).any(|id| {
            let body = self.index.function(id).function.body.as_ref();
            body.is_some_and(|body| !self.index.function(id).is_test && self.may_write(id, body, cell))
        })
    }

    /// A function and all that it calls.
    fn called_from(&self, own: FunctionId) -> BTreeSet<FunctionId> {
        let mut called = BTreeSet::new();
        let mut open = vec![own];
        while let Some(id) = open.pop() {
            if !called.insert(id) {
                continue;
            }
            let callees = self.typed(id).into_iter().flat_map(|typed| typed.callees.values());
            open.extend(callees.flat_map(|callee| match callee {
                Callee::Resolved(resolved) => resolved.targets.clone(),
                _ => Vec::new(),
            }));
        }
        called
    }

    /// Whether a function does more with a cell than to read it.
    fn may_write(&self, id: FunctionId, body: &Body, cell: Flag<'_>) -> bool {
        let typed = self.typed(id);
        let is_cell = |id: ExprId| match (cell, &body.expr(id).kind) {
            (Flag::Static(cell), ExprKind::Path(_)) => {
                typed.and_then(|typed| typed.expr_def.get(&id)) == Some(&Def::Value(cell))
            }
            (Flag::Field(owner, name), ExprKind::Field { base, name: field }) => {
                let ty = typed.map(|typed| typed.ty(*base).peel());
                field == name && matches!(ty, Some(crate::index::Ty::Adt(id, _)) if *id == owner)
            }
            _ => false,
        };
        let reads = |kind: &ExprKind| match kind {
            ExprKind::MethodCall { receiver, method, .. } => {
                matches!(method.as_str(), "get" | "borrow" | "load") && is_cell(*receiver)
            }
            _ => false,
        };
        let read = body.exprs.iter().filter(|expr| reads(&expr.kind)).count();
        let used = (0u32..).map(ExprId).take(body.exprs.len()).filter(|id| is_cell(*id)).count();
        used > read
    }
}
