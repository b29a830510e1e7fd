//! Threads and tasks: what they do is counted where they are spawned if they certainly end there, and elsewhere otherwise.

use rustc_hash::FxHashSet;

use super::calls::path_tail;
use super::{Builder, ClosureRef, Value};
use crate::flow::{Cause, Effect, Place, Rounds};
use crate::index::{FunctionId, Ty};
use crate::source::Span;
use crate::syntax::tree::{Body, ExprId, ExprKind, StmtKind};
use crate::types::{Callee, TypedBody};

/// Functions that call their closure once, and return when all that it has spawned has ended.
pub(super) fn is_thread_scope(name: &str) -> bool {
    matches!(name, "scope" | "scope_fifo" | "in_place_scope" | "in_place_scope_fifo")
}

/// Functions that start a thread or task.
pub(super) fn is_spawn(name: &str) -> bool {
    name == "spawn" || name.starts_with("spawn_") || name == "must_spawn"
}

impl Builder<'_> {
    /// `thread::scope(|s| …)`: what `s` spawns has run to its end when this returns.
    pub(super) fn thread_scope(&mut self, closure: ClosureRef, span: Span) -> Value {
        self.thread_scopes.push(self.loops.len());
        let value = self.inline_closure(closure, &[Value::default()], span);
        self.thread_scopes.pop();
        value
    }

    /// A thread or task of its own; `scope` is what it is spawned on.
    pub(super) fn spawn(&mut self, id: ExprId, name: &str, scope: Option<ExprId>, args: &[ExprId]) -> Value {
        let span = self.span(id);
        let is_joined = self.is_joined(id);
        let is_awaited = self.is_scoped(scope) || is_joined;
        // A scope panics with its threads, unless they have been joined in it.
        let is_caught = !is_joined && self.is_taken_by(id, |id| self.joins(id)) && !self.is_raised_again(id);
        for arg in args {
            let value = self.expr(*arg);
            if let Some(closure) = value.closure {
                self.lose_captured(id, closure);
                self.share_cells(&value);
                self.gives_back(id, closure);
                if is_awaited && is_caught {
                    self.swallow_panics(closure, span, |this| {
                        this.run_beside(closure, span);
                        Value::default()
                    });
                } else if is_awaited {
                    self.run_beside(closure, span);
                } else {
                    self.detach_closure(closure, span);
                }
            } else if let Some(place) = value.place
                && self.may_hold_filter(self.ty(*arg))
            {
                let cause = Cause::Call(path_tail(name));
                self.emit(Effect::Unknown { places: vec![place], cause }, span);
            }
        }
        Value::default()
    }

    /// A thread that takes filters along and gives such back: what comes by its handle takes the place of something here, and is not
    /// followed. `lag = thread::spawn(move || { lag.update(x); lag }).join().unwrap();`
    fn gives_back(&mut self, id: ExprId, closure: ClosureRef) {
        let frame = &self.frames[closure.frame];
        let ExprKind::Closure(code) = &frame.body.expr(closure.expr).kind else { return };
        let given = frame.typed.ty(code.body);
        if self.at.is_none() || !code.is_move || *given == Ty::Unknown || !self.may_hold_filter(given) {
            return;
        }
        let taken = self.captured_vars(closure).into_iter();
        let places: Vec<Place> =
            taken.filter(|var| self.may_hold_filter(&self.graph.var(*var).ty)).map(Place::var).collect();
        if !places.is_empty() {
            let cause = Cause::Code("what another thread gives back".to_owned());
            self.emit(Effect::Unknown { places, cause }, self.span(id));
        }
    }

    /// Runs a closure of another thread, which the code here waits for: once, unless it stays in a loop.
    pub(super) fn run_beside(&mut self, closure: ClosureRef, span: Span) {
        let frame = &self.frames[closure.frame];
        let place = frame.body.expr(closure.expr).span;
        if self.may_stay(frame.body, frame.typed, place) {
            self.detach_closure(closure, span);
            return;
        }
        if self.at.is_none() {
            return;
        }
        let before = self.emit(Effect::Nothing, span);
        let value = self.inline_closure(closure, &[Value::default()], span);
        self.awaited(value, span);
        // The other threads run even if this one panics.
        if self.at.is_none() {
            let after = self.add_node(Effect::Nothing, span);
            self.link(before, after);
            self.resume(after);
        }
    }

    /// Whether code may run until something else ends it, here or in what it calls.
    fn may_stay(&self, body: &Body, typed: &TypedBody, place: Span) -> bool {
        self.reaches(body, typed, place, usize::MAX, &mut FxHashSet::default(), &|body, kind| match kind {
            ExprKind::Loop { .. } => true,
            ExprKind::While { condition, .. } => {
                !matches!(body.expr(*condition).kind, ExprKind::Binary { op: "<" | "<=" | ">" | ">=" | "!=", .. })
            }
            _ => false,
        })
    }

    /// Whether there is an expression of some kind at a place, or in what is called there, so many calls deep.
    pub(super) fn reaches(
        &self,
        body: &Body,
        typed: &TypedBody,
        place: Span,
        depth: usize,
        seen: &mut FxHashSet<FunctionId>,
        is_it: &dyn Fn(&Body, &ExprKind) -> bool,
    ) -> bool {
        let inside = (0u32..).zip(&body.exprs).filter(|(_, expr)| place.contains(expr.span));
        inside.into_iter().any(|(number, expr)| {
            is_it(body, &expr.kind)
                || match typed.callees.get(&ExprId(number)) {
                    Some(Callee::Resolved(resolved)) if depth > 0 => resolved.targets.iter().any(|target| {
                        let code = self.program.index.function(*target).function.body.as_ref();
                        let Some((body, typed)) = code.zip(self.program.typed(*target)) else { return false };
                        let all = body.expr(body.root).span;
                        seen.insert(*target) && self.reaches(body, typed, all, depth - 1, seen, is_it)
                    }),
                    _ => false,
                }
        })
    }

    /// Whether what is spawned on a value has ended where the code that spawns it goes on: the value is the handle that a scope
    /// lends its closure, and no loop that may never end stands between the two.
    fn is_scoped(&self, scope: Option<ExprId>) -> bool {
        let Some(scope) = scope else { return false };
        let is_handle = match self.ty(scope).peel().external_name() {
            Some(name) => matches!(name, "Scope" | "ScopeFifo"),
            None => !self.thread_scopes.is_empty() && self.is_lent_by_caller(scope),
        };
        let outside = self.thread_scopes.last().copied().unwrap_or(0);
        let mut between = self.loops.iter().skip(outside);
        is_handle && between.all(|id| self.graph.loop_info(*id).rounds != Rounds::Unbounded)
    }

    /// Whether an expression is a parameter of a closure.
    fn is_lent_by_caller(&self, id: ExprId) -> bool {
        let (body, typed) = (self.body(), self.typed());
        let Some(local) = typed.expr_local.get(&id) else { return false };
        body.exprs.iter().any(|expr| match &expr.kind {
            ExprKind::Closure(code) => code.params.iter().any(|(pat, _)| typed.pat_local.get(pat) == Some(local)),
            _ => false,
        })
    }

    /// Whether the block that spawns a thread joins it on every way that goes on, and panics if it has: then it runs once.
    fn is_joined(&self, spawned: ExprId) -> bool {
        // `handle.join().unwrap()`
        self.is_taken_by(spawned, |id| self.joins(self.unwrapped(id)?))
    }

    /// The handle that an expression joins.
    fn joins(&self, id: ExprId) -> Option<ExprId> {
        match &self.body().expr(id).kind {
            ExprKind::MethodCall { receiver, method, .. } if method == "join" => Some(*receiver),
            _ => None,
        }
    }

    /// What an expression panics without.
    pub(super) fn unwrapped(&self, id: ExprId) -> Option<ExprId> {
        match &self.body().expr(id).kind {
            ExprKind::MethodCall { receiver, method, .. } if matches!(method.as_str(), "unwrap" | "expect") => {
                Some(*receiver)
            }
            _ => None,
        }
    }

    /// Whether something takes the value of an expression, by itself or by the name that it gets, as a statement of that block.
    pub(super) fn is_taken_by(&self, value: ExprId, taken: impl Fn(ExprId) -> Option<ExprId>) -> bool {
        let (body, typed) = (self.body(), self.typed());
        let mut ids = (0u32..).map(ExprId).take(body.exprs.len());
        if ids.by_ref().filter_map(&taken).any(|by| self.behind_results(by) == value) {
            return true;
        }
        body.blocks().any(|block| {
            let made = block.stmts.iter().enumerate().find_map(|(at, stmt)| match &stmt.kind {
                StmtKind::Let { pat, init: Some(init), .. } if self.behind_results(*init) == value => {
                    Some((at, typed.pat_local.get(pat)?))
                }
                _ => None,
            });
            let Some((at, local)) = made else { return false };
            let behind = block.stmts[at + 1..].iter().filter_map(|stmt| match &stmt.kind {
                StmtKind::Let { init, .. } => *init,
                StmtKind::Expr { expr, .. } => Some(*expr),
            });
            behind.chain(block.tail).filter_map(&taken).any(|by| typed.expr_local.get(&by) == Some(local))
        })
    }

    /// What an expression unwraps: `builder.spawn(…)` in `builder.spawn(…).unwrap()`.
    fn behind_results(&self, id: ExprId) -> ExprId {
        match (self.unwrapped(id), &self.body().expr(id).kind) {
            (Some(inner), _) => self.behind_results(inner),
            (None, ExprKind::Try(inner)) => self.behind_results(*inner),
            _ => id,
        }
    }
}
