//! Futures that are dropped before they end: whether a law may have run before the last thing that they wait for.

use super::ClosureRef;
use crate::flow::lower::futures::Deferred;
use crate::flow::lower::{Builder, Value};
use crate::flow::{About, Effect, NodeId};
use crate::index::FunctionId;
use crate::syntax::tree::{BlockKind, Body, ExprId, ExprKind, MacroKind, StmtKind};
use crate::types::{Callee, TypedBody};

/// How deep functions are followed.
const MAX_DEPTH: u32 = 4;

/// What a future does, as it is written.
struct Ways<'a> {
    body: &'a Body,
    typed: &'a TypedBody,
    depth: u32,
    /// Whether one of its ways waits after a law has run.
    waits: bool,
}

impl Builder<'_> {
    /// What a future may have done by the time that another one has ended: it is dropped at one of the places where it waits, or has
    /// not begun.
    pub(in crate::flow::lower) fn run_unfinished(&mut self, future: Option<ExprId>, value: &Value) {
        let Some(id) = future.filter(|_| self.at.is_some() && self.updates_unfinished(value)) else { return };
        let span = self.span(id);
        let about = About { is_event: true, ..self.about(id) };
        let (runs, dropped) = self.opaque_branch(span, self.text(id), about);
        let after = self.add_node(Effect::Nothing, span);
        self.resume(runs);
        let first = self.graph.nodes.len();
        self.run_to_end(value.clone(), span);
        let waiting: Vec<NodeId> = self.graph.node_ids().skip(first).collect();
        for node in waiting {
            if matches!(self.graph.node(node).effect, Effect::Suspend) {
                self.link(node, after);
            }
        }
        self.jump(after);
        self.resume(dropped);
        self.jump(after);
        self.resume(after);
    }

    /// Whether a future may have run a law where it is dropped because another one has ended first. What follows the last thing that it
    /// waits for runs only where it ends itself.
    fn updates_unfinished(&self, future: &Value) -> bool {
        future.closure.is_some_and(|closure| self.is_of_future(closure) && self.waits_behind_law(closure, 0))
    }

    fn waits_behind_law(&self, future: ClosureRef, depth: u32) -> bool {
        let key = (future.frame, future.expr);
        let among = |values: &[Value]| {
            let mut futures = values.iter().filter_map(|value| value.closure);
            futures.any(|inner| self.is_of_future(inner) && self.waits_behind_law(inner, depth + 1))
        };
        let frame = &self.frames[future.frame];
        match self.deferred.get(&key) {
            _ if depth > MAX_DEPTH => true,
            Some(Deferred::Function { resolved, .. }) => {
                resolved.targets.iter().any(|target| self.function_waits(*target, false, depth).1)
            }
            Some(Deferred::Closure { closure, .. }) => {
                let frame = &self.frames[closure.frame];
                self.body_waits(frame.body, frame.typed, closure.expr, false, depth).1
            }
            Some(Deferred::Several { values, .. }) => among(values),
            None => match self.choices.get(&key) {
                Some(choices) => choices.iter().any(|choice| self.waits_behind_law(*choice, depth + 1)),
                None => self.body_waits(frame.body, frame.typed, future.expr, false, depth).1,
            },
        }
    }

    /// Whether a law may have run behind a function, and whether it waits for something behind one.
    fn function_waits(&self, target: FunctionId, has_run: bool, depth: u32) -> (bool, bool) {
        let body = self.program.index.function(target).function.body.as_ref();
        match (body, self.program.typed(target)) {
            (Some(body), Some(typed)) if depth < MAX_DEPTH => {
                self.body_waits(body, typed, body.root, has_run, depth + 1)
            }
            _ => (has_run, has_run),
        }
    }

    fn body_waits(&self, body: &Body, typed: &TypedBody, root: ExprId, has_run: bool, depth: u32) -> (bool, bool) {
        let mut ways = Ways { body, typed, depth, waits: false };
        let behind = match &body.expr(root).kind {
            ExprKind::Closure(code) => self.go_through(&mut ways, code.body, has_run),
            // The block of the future itself.
            ExprKind::Block(_) => self.go_through_block(&mut ways, root, has_run),
            _ => self.go_through(&mut ways, root, has_run),
        };
        (behind, ways.waits)
    }

    /// Whether a law may have run behind an expression, if one may have before it.
    fn go_through(&self, ways: &mut Ways<'_>, id: ExprId, has_run: bool) -> bool {
        if ways.waits {
            return has_run;
        }
        let body = ways.body;
        match &body.expr(id).kind {
            ExprKind::If { condition, then, otherwise } => {
                let asked = self.go_through(ways, *condition, has_run);
                let by_then = self.go_through(ways, *then, asked);
                otherwise.map_or(asked, |other| self.go_through(ways, other, asked)) || by_then
            }
            ExprKind::Match { scrutinee, arms } => {
                let asked = self.go_through(ways, *scrutinee, has_run);
                arms.iter().fold(false, |behind, arm| {
                    let before = arm.guard.map_or(asked, |guard| self.go_through(ways, guard, asked));
                    self.go_through(ways, arm.body, before) || behind
                })
            }
            // What is not awaited runs elsewhere.
            ExprKind::Block(block) if block.kind == BlockKind::Async => has_run,
            ExprKind::Block(_) => self.go_through_block(ways, id, has_run),
            ExprKind::Loop { .. } | ExprKind::While { .. } | ExprKind::For { .. } => {
                let after_one = self.go_through_parts(ways, id, has_run);
                self.go_through_parts(ways, id, after_one)
            }
            ExprKind::Return(_) => {
                self.go_through_parts(ways, id, has_run);
                false
            }
            ExprKind::Await(inner) => self.go_through_await(ways, *inner, has_run),
            ExprKind::Macro(called) if matches!(called.kind, MacroKind::Select(_) | MacroKind::Join { .. }) => {
                let behind = self.go_through_parts(ways, id, has_run);
                ways.waits |= has_run || behind && matches!(called.kind, MacroKind::Join { .. });
                behind
            }
            ExprKind::Call { .. } | ExprKind::MethodCall { .. } => {
                let before = self.go_through_parts(ways, id, has_run);
                before || self.calls_law(ways, id)
            }
            _ => self.go_through_parts(ways, id, has_run),
        }
    }

    fn go_through_block(&self, ways: &mut Ways<'_>, id: ExprId, has_run: bool) -> bool {
        let ExprKind::Block(block) = &ways.body.expr(id).kind else { return has_run };
        let behind = block.stmts.iter().fold(has_run, |has_run, stmt| match &stmt.kind {
            StmtKind::Let { init, otherwise, .. } => {
                let given = init.map_or(has_run, |init| self.go_through(ways, init, has_run));
                if let Some(otherwise) = otherwise {
                    self.go_through(ways, *otherwise, given);
                }
                given
            }
            StmtKind::Expr { expr, .. } => self.go_through(ways, *expr, has_run),
        });
        block.tail.map_or(behind, |tail| self.go_through(ways, tail, behind))
    }

    /// What is awaited: a function that is read waits where it says so, and anything else may not be ready.
    fn go_through_await(&self, ways: &mut Ways<'_>, awaited: ExprId, has_run: bool) -> bool {
        let body = ways.body;
        if let ExprKind::Block(_) = &body.expr(awaited).kind {
            return self.go_through_block(ways, awaited, has_run);
        }
        let before = match &body.expr(awaited).kind {
            ExprKind::Call { .. } | ExprKind::MethodCall { .. } => self.go_through_parts(ways, awaited, has_run),
            _ => self.go_through(ways, awaited, has_run),
        };
        match ways.typed.callees.get(&awaited) {
            Some(Callee::Resolved(call)) if !call.targets.is_empty() => {
                let mut behind = before || call.law.is_some();
                for target in &call.targets {
                    let (runs, waits) = self.function_waits(*target, before, ways.depth);
                    behind |= runs;
                    ways.waits |= waits;
                }
                behind
            }
            _ => {
                ways.waits |= before;
                before
            }
        }
    }

    fn go_through_parts(&self, ways: &mut Ways<'_>, id: ExprId, has_run: bool) -> bool {
        ways.body.children(id).into_iter().fold(has_run, |has_run, part| self.go_through(ways, part, has_run))
    }

    fn calls_law(&self, ways: &Ways<'_>, id: ExprId) -> bool {
        matches!(ways.typed.callees.get(&id), Some(Callee::Resolved(call)) if self.may_run_law(call, 0))
    }
}
