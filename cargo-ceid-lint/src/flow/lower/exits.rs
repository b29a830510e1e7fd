//! Ways out: the ends of blocks, `break`, `continue`, `return`, `?`, and the bodies they leave.

use super::{Builder, Value};
use crate::flow::{About, Cause, Effect, GuardId, Head, Mark, NodeId, Place, Returned, Var};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{Block, ExprId, OpaqueMacro, WayOut};

/// Something that is left by `return`, `break` or `?`.
pub(super) struct Scope {
    pub(super) kind: ScopeKind,
    pub(super) guards: Vec<GuardId>,
}

pub(super) enum ScopeKind {
    /// A block: its guards end with it.
    Block,
    /// A loop, or a block with a label: where `break` and `continue` go, and what holds the value.
    Breakable {
        label: Option<String>,
        is_loop: bool,
        frame_depth: u32,
        after: NodeId,
        again: Option<NodeId>,
        value: Var,
    },
    /// The body of a function or closure that is inlined, or of a `try` or `async` block: where `return` or `?` goes.
    Body { catches_return: bool, after: NodeId, value: Var },
}

impl Builder<'_> {
    pub(super) fn open_block(&mut self) {
        self.scopes.push(Scope { kind: ScopeKind::Block, guards: Vec::new() });
    }

    /// The number of the innermost scope.
    pub(super) fn innermost(&self) -> usize {
        self.scopes.len().saturating_sub(1)
    }

    /// Ends the innermost block: its guards are dropped.
    pub(super) fn close_block(&mut self, span: Span) {
        self.close_block_without(None, span);
    }

    /// The same, but one of its guards is what the block gives: it lives on outside.
    pub(super) fn close_block_without(&mut self, moved: Option<GuardId>, span: Span) {
        if let Some(mut scope) = self.scopes.pop() {
            let before = scope.guards.len();
            scope.guards.retain(|guard| Some(*guard) != moved);
            if let (Some(outer), Some(moved)) = (self.scopes.last_mut(), moved.filter(|_| scope.guards.len() < before))
            {
                outer.guards.push(moved);
                self.ended.insert(moved);
            }
            self.end_guards(&scope.guards, span);
        }
    }

    /// Code that `?` leaves (and `return`, if it is a function's or an async block's): its value is the value of the whole.
    pub(super) fn inline_body(
        &mut self,
        ty: Ty,
        span: Span,
        catches_return: bool,
        inside: impl FnOnce(&mut Self) -> Value,
    ) -> Value {
        let join = self.new_join(ty, span);
        let kind = ScopeKind::Body { catches_return, after: join.after, value: join.value };
        self.scopes.push(Scope { kind, guards: Vec::new() });
        let value = inside(self);
        let moved = self.moved_guard(&value);
        self.close_block_without(moved, span);
        self.end_branch(&join, &value, span);
        self.close_join(&join)
    }

    pub(super) fn labelled_block(&mut self, id: ExprId, label: String, block: &Block) -> Value {
        let span = self.span(id);
        let join = self.new_join(self.ty(id).clone(), span);
        let kind = ScopeKind::Breakable {
            label: Some(label),
            is_loop: false,
            frame_depth: self.depth,
            after: join.after,
            again: None,
            value: join.value,
        };
        self.scopes.push(Scope { kind, guards: Vec::new() });
        let value = self.plain_block(block, span);
        self.scopes.pop();
        self.end_branch(&join, &value, span);
        self.close_join(&join)
    }

    pub(super) fn break_expr(&mut self, id: ExprId, label: Option<&String>, value: Option<ExprId>) -> Value {
        let value = value.map(|value| self.expr(value)).unwrap_or_default();
        self.break_with(&value, label, self.span(id));
        Value::default()
    }

    fn break_with(&mut self, value: &Value, label: Option<&String>, span: Span) {
        if let Some((at, after, var)) = self.target(label, false) {
            self.end_scopes(at + 1, None, span);
            self.emit(Effect::Mark(Mark::Break), span);
            self.join_made(value, var, span);
            self.set(var, value, span);
            self.jump(after);
        }
        self.at = None;
    }

    pub(super) fn continue_expr(&mut self, id: ExprId, label: Option<&String>) -> Value {
        self.go_on(label, self.span(id));
        Value::default()
    }

    fn go_on(&mut self, label: Option<&String>, span: Span) {
        if let Some((at, again, _)) = self.target(label, true) {
            // The `continue` itself is a step of the path.
            self.emit(Effect::Mark(Mark::Continue), span);
            self.end_scopes(at + 1, None, span);
            self.jump(again);
        }
        self.at = None;
    }

    /// The ways out that a macro may take whose tokens hold them.
    pub(super) fn may_leave(&mut self, call: &OpaqueMacro) {
        for way in &call.ways_out {
            if self.at.is_none() {
                return;
            }
            let about = About { unread: Some(Cause::WayOut(call.path.clone())), ..About::default() };
            let (leaves, stays) = self.opaque_branch(call.span, format!("{}!", call.path), about);
            self.resume(leaves);
            match way {
                WayOut::Continue(label) => self.go_on(label.as_ref(), call.span),
                WayOut::Break(label) => self.break_with(&Value::default(), label.as_ref(), call.span),
                WayOut::Return => self.return_value(Value::default(), call.span, true),
                WayOut::Failure => {
                    let failed = Value { head: Some("-".to_owned()), ..Value::default() };
                    self.return_value(failed, call.span, false);
                }
            }
            self.resume(stays);
        }
    }

    /// The scope that a `break` or `continue` leaves, where it goes, and what holds its value.
    fn target(&self, label: Option<&String>, again: bool) -> Option<(usize, NodeId, Var)> {
        self.scopes.iter().enumerate().rev().find_map(|(at, scope)| match &scope.kind {
            ScopeKind::Breakable { label: own, is_loop, frame_depth, after, again: back, value }
                if *frame_depth == self.depth
                    && (label.is_some() || *is_loop)
                    && (label.is_none() || label == own.as_ref()) =>
            {
                if again {
                    back.map(|back| (at, back, *value))
                } else {
                    Some((at, *after, *value))
                }
            }
            _ => None,
        })
    }

    /// Ends the guards of all scopes from the one at that depth on, but for the one that lives on elsewhere.
    fn end_scopes(&mut self, first: usize, moved: Option<GuardId>, span: Span) {
        let of_scope = |scope: &Scope| scope.guards.iter().copied().filter(|id| Some(*id) != moved).collect();
        let guards: Vec<Vec<_>> = self.scopes[first..].iter().map(of_scope).collect();
        for guards in guards.iter().rev() {
            self.end_guards(guards, span);
        }
    }

    pub(super) fn return_expr(&mut self, id: ExprId, value: Option<ExprId>) -> Value {
        let value = value.map(|value| self.expr(value)).unwrap_or_default();
        let span = self.span(id);
        self.emit(Effect::Mark(Mark::Return), span);
        self.return_value(value, span, true);
        Value::default()
    }

    /// Leaves the innermost function or closure (`return`), or whatever `?` leaves.
    pub(super) fn return_value(&mut self, value: Value, span: Span, by_return: bool) {
        let body = self.scopes.iter().enumerate().rev().find_map(|(at, scope)| match &scope.kind {
            ScopeKind::Body { catches_return, after, value } if *catches_return || !by_return => {
                Some((at, *after, *value))
            }
            _ => None,
        });
        match body {
            Some((at, after, var)) => {
                self.join_made(&value, var, span);
                self.set(var, &value, span);
                self.arrived.entry(var).or_default().push(value.closure);
                // A guard that is given back lives on where the value goes; a future that the function gives back runs after all
                // of the function's own scopes.
                let moved = self.moved_guard(&value);
                if let Some(around) = at.checked_sub(1) {
                    self.scopes[around].guards.extend(moved);
                }
                self.ended.extend(moved);
                self.end_scopes(at + 1, moved, span);
                self.jump(after);
            }
            None => {
                let moved = self.moved_guard(&value);
                self.end_scopes(0, moved, span);
                self.leave_function(value, span);
            }
        }
        self.at = None;
    }

    /// The end of the function's own graph.
    pub(super) fn leave_function(&mut self, value: Value, span: Span) {
        // A function that gives back a future is an `async fn` in its long form.
        let value = self.awaited(value, span);
        let value = self.lent_on(value);
        let value = self.given_as_copy(value, span);
        self.keep_closure(&value, span);
        if self.at.is_some() {
            if let Some(var) = value.same_as {
                let total = self.total_heads(&self.graph.var(var).ty.clone());
                let subject = self.subject(self.pure_var(var), total.clone());
                for head in total.unwrap_or_else(|| self.numbers_given(var)) {
                    self.head_bit(subject, &head);
                }
            }
            let returned = Returned { place: value.place, head: value.head, same_as: value.same_as };
            self.emit(Effect::Return(returned), span);
        }
        self.at = None;
    }

    /// The numbers that a variable is given one by one.
    fn numbers_given(&self, var: Var) -> Vec<Head> {
        let given = self.graph.nodes.iter().filter_map(|node| match &node.effect {
            Effect::Set(set) if set.place == Place::var(var) => set.head.clone(),
            _ => None,
        });
        given.filter(|head| head.parse::<i64>().is_ok()).collect()
    }

    /// `expr?`
    pub(super) fn try_expr(&mut self, id: ExprId, inner: ExprId) -> Value {
        let value = self.expr(inner);
        if self.at.is_none() {
            return Value::default();
        }
        let span = self.span(id);
        let mark = Span::new(span.file, span.end.saturating_sub(1), span.end);
        // `let sample = read()?`: what is asked for goes there and nowhere else.
        let binds = if self.target_value == Some((self.frame, id)) { self.targets.clone() } else { Vec::new() };
        let about = self.about_presence(inner, binds);
        let text = format!("{}?", self.text(inner));
        let (good, bad) = self.branch_on_head(&value, "+", "-", mark, text, about);
        self.resume(bad);
        let failed = Value { head: Some("-".to_owned()), ..Value::default() };
        self.return_value(failed, mark, false);
        self.resume(good);
        self.copied_out(id, inner, Value { place: value.place, is_owned: value.is_owned, ..Value::default() })
    }

    /// Nothing follows.
    pub(super) fn diverge(&mut self, span: Span) {
        self.emit(Effect::Diverge, span);
        self.at = None;
    }
}
