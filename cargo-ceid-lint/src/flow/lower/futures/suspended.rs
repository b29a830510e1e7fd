//! Where a task may stand still while others run: at an `.await` of something that may not be ready.

use crate::flow::lower::Builder;
use crate::flow::{Effect, Program};
use crate::index::FunctionId;
use crate::source::Span;
use crate::syntax::tree::{BlockKind, ExprId, ExprKind, MacroKind};
use crate::types::{Callee, TypedBody};

/// How deep functions are followed.
const MAX_DEPTH: u32 = 4;

impl Builder<'_> {
    /// Other tasks may run here.
    pub(in crate::flow::lower) fn suspend(&mut self, span: Span) {
        if self.at.is_some() {
            self.emit(Effect::Suspend, span);
        }
    }

    /// Whether what is awaited may not be ready. An `async` block is lowered where it is awaited, and tells by itself where it waits.
    pub(in crate::flow::lower) fn may_suspend(&self, awaited: ExprId) -> bool {
        let is_block =
            matches!(&self.body().expr(awaited).kind, ExprKind::Block(block) if block.kind == BlockKind::Async);
        !is_block && may_suspend(self.program, self.typed(), awaited, 0)
    }
}

fn may_suspend(program: &Program<'_>, typed: &TypedBody, awaited: ExprId, depth: u32) -> bool {
    match typed.callees.get(&awaited) {
        Some(Callee::Resolved(resolved)) if !resolved.targets.is_empty() => {
            resolved.targets.iter().any(|target| awaits(program, *target, depth))
        }
        Some(Callee::External(path)) => !path.ends_with("future::ready"),
        _ => true,
    }
}

/// Whether a function may wait for something that is not ready.
fn awaits(program: &Program<'_>, id: FunctionId, depth: u32) -> bool {
    let function = &program.index.function(id).function;
    let (Some(body), Some(typed)) = (&function.body, program.typed(id)) else { return true };
    depth >= MAX_DEPTH
        || !function.is_async
        || body.exprs.iter().any(|expr| match &expr.kind {
            ExprKind::Await(inner) => may_suspend(program, typed, *inner, depth + 1),
            ExprKind::Macro(called) => matches!(called.kind, MacroKind::Select(_) | MacroKind::Join { .. }),
            ExprKind::Opaque(_) | ExprKind::Unknown { .. } => true,
            _ => false,
        })
}
