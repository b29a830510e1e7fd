//! Closures and functions whose bodies are read where they run, and code that runs elsewhere.

use super::{Builder, ClosureRef, Frame, MAX_INLINE, Value};
use crate::flow::{Cause, Effect, Place};
use crate::index::FunctionId;
use crate::source::Span;
use crate::syntax::tree::ExprKind;

impl Builder<'_> {
    /// Runs a closure here.
    pub(super) fn inline_closure(&mut self, closure: ClosureRef, args: &[Value], span: Span) -> Value {
        if self.at.is_none() {
            return Value::default();
        }
        if self.depth >= MAX_INLINE {
            let places = self.captured(closure);
            let cause = Cause::Limit(format!("closures are nested more than {MAX_INLINE} deep"));
            self.emit(Effect::Unknown { places, cause }, span);
            return Value::default();
        }
        let body = self.frames[closure.frame].body;
        let ExprKind::Closure(code) = &body.expr(closure.expr).kind else { return Value::default() };
        let outer = std::mem::replace(&mut self.frame, closure.frame);
        self.depth += 1;
        let ty = self.ty(code.body).clone();
        let value = self.inline_body(ty, body.expr(code.body).span, true, |this| {
            for (number, (pat, _)) in code.params.iter().enumerate() {
                let value = args.get(number).cloned().unwrap_or_default();
                this.bind_pattern(*pat, &value);
            }
            this.expr(code.body)
        });
        self.depth -= 1;
        self.frame = outer;
        value
    }

    /// Runs a function here, because it gets a closure; `None` if that cannot be done.
    pub(super) fn inline_function(&mut self, target: FunctionId, args: &[Value], span: Span) -> Option<Value> {
        let def = self.program.index.function(target);
        let body = def.function.body.as_ref()?;
        let typed = self.program.typed(target)?;
        if self.depth >= MAX_INLINE || self.inlining.contains(&target) {
            return None;
        }
        self.frames.push(Frame::new(target, body, typed));
        let outer = std::mem::replace(&mut self.frame, self.frames.len() - 1);
        self.depth += 1;
        self.inlining.push(target);
        let ty = self.ty(body.root).clone();
        let value = self.inline_body(ty, span, true, |this| {
            for (number, pat) in body.params.iter().enumerate() {
                let value = args.get(number).cloned().unwrap_or_default();
                this.bind_pattern(*pat, &value);
            }
            this.expr(body.root)
        });
        self.inlining.pop();
        self.depth -= 1;
        self.frame = outer;
        Some(value)
    }

    /// A closure that runs in a thread of its own (`certain`), or that something unseen may run any number of times.
    pub(super) fn detach_closure(&mut self, closure: ClosureRef, name: &str, certain: bool, span: Span) {
        if self.at.is_none() {
            return;
        }
        if !certain {
            let places = self.captured(closure);
            if !places.is_empty() {
                let cause = Cause::Closure(super::calls::path_tail(name));
                self.emit(Effect::Unknown { places, cause }, span);
            }
        }
        self.detached(span, |this| {
            this.inline_closure(closure, &[], span);
        });
    }

    /// Code that runs elsewhere or later: a branch that the code here does not take.
    pub(super) fn detached(&mut self, span: Span, inside: impl FnOnce(&mut Self)) {
        if self.at.is_none() {
            return;
        }
        let fork = self.emit(Effect::Fork, span);
        let here = self.add_node(Effect::Nothing, span);
        self.link(fork, here);
        let loops = std::mem::take(&mut self.loops);
        let scopes = std::mem::take(&mut self.scopes);
        let was_detached = std::mem::replace(&mut self.is_detached, true);
        let there = self.add_node(Effect::Nothing, span);
        self.link(fork, there);
        self.resume(there);
        self.inline_body(crate::index::Ty::Unknown, span, true, |this| {
            inside(this);
            Value::default()
        });
        if self.at.is_some() {
            self.emit(Effect::End, span);
        }
        self.loops = loops;
        self.scopes = scopes;
        self.is_detached = was_detached;
        self.resume(here);
    }

    /// The variables that the parameters of a closure bind.
    pub(super) fn closure_vars(&mut self, closure: ClosureRef) -> Vec<crate::flow::Var> {
        let body = self.frames[closure.frame].body;
        let ExprKind::Closure(code) = &body.expr(closure.expr).kind else { return Vec::new() };
        let outer = std::mem::replace(&mut self.frame, closure.frame);
        let locals: Vec<_> = code.params.iter().flat_map(|(pat, _)| self.locals_of(*pat)).collect();
        let vars = locals.into_iter().map(|local| self.var_of(local)).collect();
        self.frame = outer;
        vars
    }

    /// The variables of its surroundings that a closure names.
    fn captured(&mut self, closure: ClosureRef) -> Vec<Place> {
        let frame = &self.frames[closure.frame];
        let span = frame.body.expr(closure.expr).span;
        let mut places: Vec<Place> = frame
            .body
            .exprs
            .iter()
            .enumerate()
            .filter(|(_, expr)| span.contains(expr.span))
            .filter_map(|(number, _)| {
                let id = crate::syntax::tree::ExprId(u32::try_from(number).ok()?);
                frame.typed.expr_local.get(&id)
            })
            .filter_map(|local| frame.vars.get(local))
            .filter(|var| self.may_hold_filter(&self.graph.var(**var).ty))
            .map(|var| Place::var(*var))
            .collect();
        places.sort();
        places.dedup();
        places
    }
}
