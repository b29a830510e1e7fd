//! `loop { if i == n { break; } …; i += 1; }` counts as `while i != n { …; i += 1; }` does.

use super::super::{Builder, Value};
use crate::flow::{CycleKind, Effect, Place, Rounds};
use crate::source::Span;
use crate::syntax::tree::{Block, ExprId, ExprKind, StmtKind};

impl Builder<'_> {
    /// A `loop` that begins each round by asking whether it was the last; `None` if it is another one.
    pub(super) fn counting_loop(
        &mut self,
        id: ExprId,
        label: Option<&String>,
        keyword: Span,
        body: ExprId,
    ) -> Option<Value> {
        let (condition, leave, rest) = self.asks_for_end(body)?;
        let ExprKind::Binary { op, .. } = &self.body().expr(condition).kind else { return None };
        let goes_on = match *op {
            "==" => "!=",
            ">=" => "<",
            "<=" => ">",
            _ => return None,
        };
        let counted = self.rounds_while(label, goes_on, condition, body);
        counted.counter?;
        let text = self.text(condition);
        let this_loop = self.begin_loop(CycleKind::Loop, keyword, Rounds::Unbounded, text);
        counted.tell(&mut self.graph.loops[this_loop.0 as usize]);
        let after = self.add_node(Effect::Nothing, self.span(id));
        self.loops.push(this_loop);
        let head = self.emit(Effect::LoopHead(this_loop), keyword);
        self.graph.loops[this_loop.0 as usize].head = head;
        let round = self.add_node(Effect::Nothing, keyword);
        let done = self.add_node(Effect::Nothing, keyword);
        self.link(head, round);
        self.link(head, done);
        self.push_loop_scope(label, after, head, keyword);
        let value = self.value_of_loop();
        self.resume(done);
        self.expr(leave);
        self.resume(round);
        self.note_sampled(this_loop, body);
        self.plain_block(&rest, self.span(body));
        self.pop_loop_scope();
        self.jump(head);
        self.loops.pop();
        self.resume_if_reached(after);
        Some(Value { place: value.map(Place::var), same_as: value, ..Value::default() })
    }

    /// The question with which each round of a loop begins, what leaves the loop, and the rest of the round.
    fn asks_for_end(&self, body: ExprId) -> Option<(ExprId, ExprId, Block)> {
        let tree = self.body();
        let ExprKind::Block(block) = &tree.expr(body).kind else { return None };
        let (first, rest) = block.stmts.split_first()?;
        let StmtKind::Expr { expr, .. } = &first.kind else { return None };
        let ExprKind::If { condition, then, otherwise: None } = &tree.expr(*expr).kind else { return None };
        let ExprKind::Block(leaving) = &tree.expr(*then).kind else { return None };
        let last = match (leaving.tail, leaving.stmts.last().map(|stmt| &stmt.kind)) {
            (Some(tail), _) => tail,
            (None, Some(StmtKind::Expr { expr, .. })) => *expr,
            _ => return None,
        };
        let leaves = matches!(tree.expr(last).kind, ExprKind::Return(_) | ExprKind::Break { label: None, .. });
        let is_plain = first.cfg.is_none() && block.items.is_empty();
        (leaves && is_plain).then(|| {
            let rest = Block { stmts: rest.to_vec(), tail: block.tail, ..Block::default() };
            (*condition, *then, rest)
        })
    }
}
