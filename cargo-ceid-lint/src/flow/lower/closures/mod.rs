//! Closures and functions whose bodies are read where they run, and code that runs elsewhere.

mod callables;

use super::sources::Source;
use super::stored::{Holder, StoredClosure};
use super::{Builder, Frame, MAX_INLINE, Value};
use rustc_hash::FxHashSet;
use std::collections::BTreeSet;

use crate::flow::{About, Caller, Cause, CycleKind, Effect, LoopId, LoopInfo, NodeId, Place, Rounds, Var};
use crate::index::{FunctionId, Ty};
use crate::source::Span;
use crate::syntax::tree::{Body, ExprId, ExprKind, PatId, Receiver, Stmt, StmtKind, TypeRef};
use crate::types::{LocalId, TypedBody};

/// A closure: the frame it was written in, and its expression.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ClosureRef {
    pub(super) frame: usize,
    pub(super) expr: ExprId,
}

impl Builder<'_> {
    /// Runs a closure here.
    pub(super) fn inline_closure(&mut self, closure: ClosureRef, args: &[Value], span: Span) -> Value {
        self.note_run(closure);
        if self.at.is_none() {
            return Value::default();
        }
        if self.depth >= MAX_INLINE {
            let places = self.captured(closure);
            let cause = Cause::Limit(format!("closures are nested more than {MAX_INLINE} deep"));
            self.emit(Effect::Unknown { places, cause }, span);
            return Value::default();
        }
        if self.is_of_future(closure) {
            return self.run_future(closure, span);
        }
        let body = self.frames[closure.frame].body;
        let ExprKind::Closure(code) = &body.expr(closure.expr).kind else {
            return match self.choices.get(&(closure.frame, closure.expr)).cloned() {
                Some(choices) => self.run_one_of(&choices, args, span),
                None => self.call_item(closure, args, span),
            };
        };
        let first = self.graph.nodes.len();
        let outer = std::mem::replace(&mut self.frame, closure.frame);
        self.depth += 1;
        let ty = self.ty(code.body).clone();
        let originals = self.swap_captured(closure, None);
        let value = self.inline_body(ty, body.expr(code.body).span, true, |this| {
            this.bind_params(&code.params, args);
            let value = this.expr(code.body);
            this.note_mixed(code.body);
            value
        });
        self.swap_captured(closure, originals);
        self.depth -= 1;
        self.frame = outer;
        self.note_caller(closure, first);
        value
    }

    /// Asks here what a closure asks; control goes on where the answer is yes, and leads to `no` where it is not. Answers whether it
    /// is a question and nothing else.
    pub(super) fn inline_question(&mut self, closure: ClosureRef, args: &[Value], no: NodeId) -> bool {
        self.note_run(closure);
        let body = self.frames[closure.frame].body;
        let ExprKind::Closure(code) = &body.expr(closure.expr).kind else { return false };
        if self.at.is_none() || self.depth >= MAX_INLINE || !is_question(body, code.body) {
            return false;
        }
        let first = self.graph.nodes.len();
        let outer = std::mem::replace(&mut self.frame, closure.frame);
        self.depth += 1;
        let originals = self.swap_captured(closure, None);
        self.bind_params(&code.params, args);
        self.condition(code.body, no);
        self.swap_captured(closure, originals);
        self.depth -= 1;
        self.frame = outer;
        self.note_caller(closure, first);
        true
    }

    fn bind_params(&mut self, params: &[(PatId, TypeRef)], args: &[Value]) {
        for (number, (pat, _)) in params.iter().enumerate() {
            let value = args.get(number).cloned().unwrap_or_default();
            self.bind_pattern(*pat, &value);
            self.note_handed(*pat);
            self.note_counter(*pat, &value);
        }
    }

    /// Whether a call of a closure of the function at hand is a round of its own for what is fed with what it gives: it is one of
    /// several that a function makes in several loops, or stands in loops in loops and gives a block, and no two of the calls give
    /// the same. One behind another in the same round, all belong to the cycle around.
    pub(super) fn is_called_apart(&self, call: ExprId, closure: ClosureRef) -> bool {
        if !self.is_foreign() || self.frames[closure.frame].function != self.graph.function {
            return false;
        }
        let (body, typed) = (self.body(), self.typed());
        let local = |id: ExprId| match &body.expr(id).kind {
            ExprKind::Call { callee, .. } => typed.expr_local.get(callee),
            _ => None,
        };
        let Some(own) = local(call) else { return false };
        let ids = || (0u32..).map(ExprId).take(body.exprs.len());
        let calls: Vec<ExprId> = ids().filter(|id| local(*id) == Some(own)).collect();
        let mut given: Vec<Vec<String>> = calls
            .iter()
            .filter_map(|id| match &body.expr(*id).kind {
                ExprKind::Call { args, .. } => Some(args.iter().map(|arg| self.text(*arg)).collect()),
                _ => None,
            })
            .collect();
        given.sort();
        given.dedup();
        let is_loop = |id: &ExprId| {
            matches!(body.expr(*id).kind, ExprKind::Loop { .. } | ExprKind::While { .. } | ExprKind::For { .. })
        };
        let around = |call: ExprId| {
            let loops = ids().filter(is_loop).map(|id| body.expr(id).span);
            loops.filter(|span| span.contains(body.expr(call).span)).map(|span| span.start).max()
        };
        let round = around(call);
        let is_alone = || round.is_some() && calls.iter().filter(|other| around(**other) == round).count() == 1;
        if calls.len() > 1 { given.len() == calls.len() && is_alone() } else { self.gives_blocks(call) }
    }

    /// Whether a call stands in loops in loops of another function, the innermost of which ends, and gives a collection.
    fn gives_blocks(&self, call: ExprId) -> bool {
        let infos = self.loops.iter().rev().map(|id| &self.graph.loops[id.0 as usize]);
        let around: Vec<&LoopInfo> = infos.take_while(|info| info.is_foreign).collect();
        let ExprKind::Call { args, .. } = &self.body().expr(call).kind else { return false };
        let is_block = |arg: &ExprId| super::iterators::is_row(self.ty(*arg).peel());
        around.len() > 1 && around[0].rounds != Rounds::Unbounded && args.iter().any(is_block)
    }

    /// Runs a closure as the one round of a loop that binds what it is given, filters left out.
    pub(super) fn closure_apart(&mut self, closure: ClosureRef, args: &[Value], span: Span) -> Value {
        let bar = self.bar(closure);
        let source = Source { rounds: Rounds::Constant(1), ..Source::bounded() };
        let mut value = Value::default();
        self.run_loop(CycleKind::Closure, bar, None, source, |this, _, id| {
            value = this.inline_closure(closure, args, span);
            let mut bound = this.closure_vars(closure);
            bound.retain(|var| !this.may_hold_filter(&this.graph.var(*var).ty));
            let info = &mut this.graph.loops[id.0 as usize];
            (info.bound, info.caller) = (bound, Caller::Helper);
        });
        value
    }

    /// Notes that the foreign loops at this point call a closure of the function at hand that may update something.
    fn note_caller(&mut self, closure: ClosureRef, first: usize) {
        let is_own = self.frames[closure.frame].function == self.graph.function;
        let acts = |node: &crate::flow::Node| matches!(node.effect, Effect::Update(_) | Effect::Call(_));
        if !is_own || !self.graph.nodes[first..].iter().any(acts) {
            return;
        }
        let bar = self.bar(closure);
        for id in &self.loops {
            let info = &mut self.graph.loops[id.0 as usize];
            if info.is_foreign {
                info.closure.get_or_insert(bar);
            }
        }
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
        self.graph.read_here.insert(target);
        self.inlining.push(target);
        let ty = self.ty(body.root).clone();
        let value = self.inline_body(ty, span, true, |this| {
            for (number, pat) in body.params.iter().enumerate() {
                let value = args.get(number).cloned().unwrap_or_default();
                this.bind_pattern(*pat, &value);
                this.note_handed(*pat);
                // `self` by value is nobody's name here: what it holds goes on in the result.
                if number == 0 && def.function.receiver == Some(Receiver::Value) {
                    for var in this.vars_of(*pat) {
                        this.graph.vars[var.0 as usize].name.clear();
                    }
                }
            }
            this.expr(body.root)
        });
        self.inlining.pop();
        self.depth -= 1;
        self.frame = outer;
        Some(value)
    }

    /// The `|` at which a closure begins.
    pub(super) fn bar(&self, closure: ClosureRef) -> Span {
        let expr = self.frames[closure.frame].body.expr(closure.expr);
        match &expr.kind {
            ExprKind::Closure(code) => code.bar,
            _ => expr.span,
        }
    }

    /// A closure that runs in a thread of its own.
    pub(super) fn detach_closure(&mut self, closure: ClosureRef, span: Span) {
        self.note_run(closure);
        if self.is_item(closure) {
            return;
        }
        self.detached(span, |this| {
            let value = this.inline_closure(closure, &[], span);
            this.awaited(value, span);
        });
    }

    /// A closure that something unseen may run any number of times, perhaps once per cycle. A function is judged by itself.
    pub(super) fn closure_for_unseen(&mut self, closure: ClosureRef, holder: Holder, cause: Cause, span: Span) {
        self.note_run(closure);
        if self.at.is_none() || self.is_item(closure) {
            return;
        }
        if let Some(choices) = self.choices.get(&(closure.frame, closure.expr)).cloned() {
            for choice in choices {
                self.closure_for_unseen(choice, holder, cause.clone(), span);
            }
            return;
        }
        let places = self.captured_to_update(closure);
        let handed = (!places.is_empty()).then(|| self.emit(Effect::Unknown { places: places.clone(), cause }, span));
        let id = LoopId(u32::try_from(self.graph.loops.len()).unwrap_or(u32::MAX));
        self.callback(closure, Caller::Unseen, span);
        self.graph.loops[id.0 as usize].handed.extend(handed);
        self.stored.closures.push(StoredClosure { id, places, holder });
    }

    /// A variable gets a closure. Which one it holds is not known where it gets another one somewhere.
    pub(super) fn hold_closure(&mut self, var: Var, value: &Value, span: Span) {
        let frame = &self.frames[self.frame];
        let is_given_anew = frame.vars.iter().any(|(local, own)| *own == var && frame.given_anew.contains(local));
        match value.closure {
            Some(_) if is_given_anew => {
                self.keep_closure(&Value { closure: value.closure, ..Value::default() }, span);
                self.closures.remove(&var);
            }
            Some(closure) => {
                self.closures.insert(var, closure);
            }
            None => {
                self.closures.remove(&var);
            }
        }
    }

    /// A closure that is put somewhere, from where it may be called.
    pub(super) fn keep_closure(&mut self, value: &Value, span: Span) {
        self.keep_closure_in(None, value, span);
    }

    /// A closure that is put into a variable or a part of one, if that is known.
    pub(super) fn keep_closure_in(&mut self, holder: Option<Var>, value: &Value, span: Span) {
        self.keep_iterator(value, &Cause::Code("an iterator that is kept for later".to_owned()), span);
        if let Some(closure) = value.closure {
            let cause = Cause::Code("a closure that is kept for later".to_owned());
            self.closure_for_unseen(closure, Holder::Code(holder), cause, span);
        }
    }

    /// A closure each of whose calls is a round: of a cycle, or of what may be one.
    pub(super) fn callback(&mut self, closure: ClosureRef, caller: Caller, span: Span) {
        let bar = self.bar(closure);
        let rounds = if caller == Caller::Framework { Rounds::Unbounded } else { Rounds::Bounded };
        let text = self.frames[closure.frame].body.expr(closure.expr).span;
        let text = super::patterns::shorten(self.program.sources.snippet(text));
        let (nodes, vars) = (self.graph.nodes.len(), self.graph.vars.len());
        self.detached(span, |this| {
            // What its parameters lend it lives on between its calls.
            this.closure_vars(closure);
            let source = Source { rounds, text, ..Source::bounded() };
            this.run_loop(CycleKind::Closure, bar, None, source, |this, _, id| {
                this.graph.loops[id.0 as usize].caller = caller;
                let value = this.inline_closure(closure, &[], span);
                let value = this.awaited(value, span);
                this.end_on_failure(&value, span);
            });
        });
        self.written_by_callback(closure, (nodes, vars), span);
    }

    /// What the nodes of a closure from these on write of the variables that were there before them may be written from here on:
    /// `bus.on_sample(|x| last = Some(x))`.
    fn written_by_callback(&mut self, closure: ClosureRef, (nodes, vars): (usize, usize), span: Span) {
        let code = &self.frames[closure.frame].body.expr(closure.expr).kind;
        let has_own = matches!(code, ExprKind::Closure(code) if code.is_move);
        let written = |effect: &Effect| -> Vec<Place> {
            match effect {
                Effect::Set(set) | Effect::Write(set) => vec![set.place.clone()],
                Effect::Call(site) => {
                    let lent = site.args.iter().filter(|arg| !arg.is_shared);
                    lent.filter_map(|arg| arg.place.clone().or_else(|| arg.value_of.clone())).collect()
                }
                _ => Vec::new(),
            }
        };
        let all = self.graph.nodes[nodes..].iter().flat_map(|node| written(&node.effect));
        let is_from_outside = |place: &Place| {
            let var = place.base_var().filter(|var| (var.0 as usize) < vars);
            let ty = var.map(|var| &self.graph.var(var).ty);
            ty.is_some_and(|ty| !self.may_hold_filter(ty) && (!has_own || matches!(ty, Ty::Ref(..))))
        };
        let outside: BTreeSet<Place> = all.filter(is_from_outside).collect();
        for place in outside {
            self.written_unseen(place, span);
        }
    }

    /// What a callback gives back ends its run if it is an error, `None` or `Ready`.
    fn end_on_failure(&mut self, value: &Value, span: Span) {
        let Some(var) = value.same_as else { return };
        let is_optional = matches!(self.graph.var(var).ty.peel().external_name(), Some("Option" | "Result" | "Poll"));
        if self.at.is_none() || !is_optional {
            return;
        }
        let (goes_on, ends) = self.branch_on_head(value, "+", "-", span, String::new(), About::default());
        self.resume(ends);
        self.break_out(span);
        self.resume(goes_on);
    }

    /// Code that runs elsewhere or later: a branch that the code here does not take.
    pub(super) fn detached(&mut self, span: Span, inside: impl FnOnce(&mut Self)) {
        if self.at.is_none() {
            return;
        }
        let fork = self.emit(Effect::Fork, span);
        let here = self.add_node(Effect::Nothing, span);
        self.link(fork, here);
        let around = self.loops.last().copied().or(self.detached_in);
        let outer = std::mem::replace(&mut self.detached_in, around);
        let loops = std::mem::take(&mut self.loops);
        let scopes = std::mem::take(&mut self.scopes);
        let thread_scopes = std::mem::take(&mut self.thread_scopes);
        let was_detached = std::mem::replace(&mut self.is_detached, true);
        let there = self.add_node(Effect::Nothing, span);
        self.link(fork, there);
        self.resume(there);
        self.inline_body(Ty::Unknown, span, true, |this| {
            inside(this);
            Value::default()
        });
        if self.at.is_some() {
            self.emit(Effect::End, span);
        }
        for (id, node) in (there.0..).map(NodeId).zip(&self.graph.nodes[there.0 as usize..]) {
            if node.in_loop.is_none() {
                self.graph.elsewhere.entry(id).or_insert(fork);
            }
        }
        self.loops = loops;
        self.scopes = scopes;
        self.thread_scopes = thread_scopes;
        self.is_detached = was_detached;
        self.detached_in = outer;
        self.resume(here);
    }

    /// The variables that the parameters of a closure bind.
    pub(super) fn closure_vars(&mut self, closure: ClosureRef) -> Vec<Var> {
        let body = self.frames[closure.frame].body;
        let ExprKind::Closure(code) = &body.expr(closure.expr).kind else { return Vec::new() };
        let outer = std::mem::replace(&mut self.frame, closure.frame);
        let vars = code.params.iter().flat_map(|(pat, _)| self.vars_of(*pat)).collect();
        self.frame = outer;
        vars
    }

    /// Gives the locals that a closure has copies of these variables, or those of the copies; answers what they had.
    fn swap_captured(&mut self, closure: ClosureRef, vars: Option<Vec<(LocalId, Var)>>) -> Option<Vec<(LocalId, Var)>> {
        let vars = vars.or_else(|| self.captures.get(&(closure.frame, closure.expr)).cloned())?;
        let known = &mut self.frames[closure.frame].vars;
        Some(vars.into_iter().filter_map(|(local, var)| Some((local, known.insert(local, var)?))).collect())
    }
}

/// Whether an expression is made of questions and nothing else: `!row.is_empty() && row.is_on`.
fn is_question(body: &Body, id: ExprId) -> bool {
    match &body.expr(id).kind {
        ExprKind::Not(inner) => is_question(body, *inner),
        ExprKind::Binary { op: "&&" | "||", lhs, rhs } => is_question(body, *lhs) && is_question(body, *rhs),
        ExprKind::MethodCall { receiver, args, .. } => args.is_empty() && is_named(body, *receiver),
        _ => is_named(body, id),
    }
}

/// Whether an expression is a variable or a field of one.
pub(super) fn is_named(body: &Body, id: ExprId) -> bool {
    match &body.expr(id).kind {
        ExprKind::Field { base, .. } => is_named(body, *base),
        ExprKind::Deref(inner) => is_named(body, *inner),
        kind => matches!(kind, ExprKind::Path(_)),
    }
}

/// The locals of a body that are given a value in several places.
pub(super) fn given_anew(body: &Body, typed: &TypedBody) -> FxHashSet<LocalId> {
    let assigned = body.exprs.iter().flat_map(|expr| match &expr.kind {
        ExprKind::Assign { place, .. } => {
            let places = body.assigned_places(*place);
            places.iter().filter_map(|place| typed.expr_local.get(place).copied()).collect()
        }
        ExprKind::Block(block) => {
            let begins = |stmt: &Stmt| match &stmt.kind {
                StmtKind::Let { pat, init: Some(_), .. } => typed.pat_local.get(pat).copied(),
                _ => None,
            };
            block.stmts.iter().filter_map(begins).collect::<Vec<_>>()
        }
        _ => Vec::new(),
    });
    let mut seen = FxHashSet::default();
    assigned.filter(|local| !seen.insert(*local)).collect()
}
