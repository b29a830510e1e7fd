//! Futures: what an `async fn` or an `async` block does happens where it is awaited, and nowhere if it never is.

mod pending;
mod polled;
mod suspended;
mod unfinished;

use super::{Builder, ClosureRef, Value};
use crate::flow::mark::ONE_OF_SEVERAL;
use crate::flow::{Effect, Mark, Place, UnrunKind};
use crate::index::{FunctionId, Ty};
use crate::source::Span;
use crate::syntax::tree::{BlockKind, ExprId, ExprKind, Path, TypeRef};
use crate::types::{Callee, Resolved, future_behind};

/// A call that gives a future: it runs where that is awaited.
#[derive(Clone, Debug)]
pub(super) enum Deferred {
    /// Of an `async fn`; what it is given is evaluated at once, `self` first.
    Function { resolved: Resolved, exprs: Vec<ExprId>, values: Vec<Value> },
    /// Of an `async` closure.
    Closure { closure: ClosureRef, values: Vec<Value> },
    /// Of a function that runs all the futures that it is given, as `join`, or may drop some of them, as `select`.
    Several { values: Vec<Value>, completes: bool },
}

impl Builder<'_> {
    /// A call of an `async fn`; `None` if the function is another one.
    pub(super) fn deferred_call(
        &mut self,
        id: ExprId,
        resolved: &Resolved,
        exprs: &[ExprId],
        values: &[Value],
    ) -> Option<Value> {
        self.gives_future(resolved).then(|| {
            // It is called here, even if nothing ever awaits what it gives.
            self.graph.read_here.extend(&resolved.targets);
            let resolved = resolved.clone();
            self.defer(id, Deferred::Function { resolved, exprs: exprs.to_vec(), values: values.to_vec() })
        })
    }

    /// A call of a closure that is not followed before its future is awaited.
    pub(super) fn call_closure(&mut self, id: ExprId, closure: ClosureRef, values: Vec<Value>) -> Value {
        let body = self.frames[closure.frame].body;
        match &body.expr(closure.expr).kind {
            ExprKind::Closure(code) if code.is_async => self.defer(id, Deferred::Closure { closure, values }),
            _ => {
                let span = self.span(id);
                if self.at.is_some() && !span.contains(body.expr(closure.expr).span) {
                    self.emit(Effect::Mark(Mark::ClosureCall), span);
                }
                if self.is_called_apart(id, closure) {
                    return self.closure_apart(closure, &values, span);
                }
                self.inline_closure(closure, &values, span)
            }
        }
    }

    /// A call of a function that runs the futures that it is given, by its name; `None` if it is something else.
    pub(super) fn runs_given(&mut self, id: ExprId, values: &[Value]) -> Option<Value> {
        let future = values.iter().rev().find(|value| self.is_future(value) || self.is_polled(value))?;
        let name = self.called_name(id);
        if super::threads::is_spawn(name) {
            let span = self.span(id);
            for closure in values.iter().filter_map(|value| value.closure) {
                self.detach_closure(closure, span);
            }
            return Some(Value::default());
        }
        if blocks_on(name) || self.gives_output_of_its_own(id, values) {
            return Some(self.run_to_end(future.clone(), self.span(id)));
        }
        // What stands in the crate under the name of a well-known one is only a stand-in for it; a timeout is what its body says.
        let is_known = name.starts_with("select") || name.starts_with("join");
        let completes = combines(name).filter(|_| is_known || !self.is_seen(id))?;
        Some(self.defer(id, Deferred::Several { values: values.to_vec(), completes }))
    }

    /// Whether a function gives what the future that it is given ends with, which it cannot have before that has ended:
    /// `fn wait_for<F: Future>(future: F) -> F::Output`.
    fn gives_output_of_its_own(&self, id: ExprId, values: &[Value]) -> bool {
        let Some(target) = self.only_target(id) else { return false };
        let function = &self.program.index.function(target).function;
        let futures = || values.iter().filter(|value| value.closure.is_some() || self.is_polled(value)).count();
        let TypeRef::Path(output) = &function.output else { return false };
        let owner = match (&output.self_ty, output.segments.as_slice()) {
            (Some(ty), [.., last]) if last.name == "Output" => (**ty).clone(),
            (None, [owner, last]) if last.name == "Output" => {
                TypeRef::Path(Path { segments: vec![owner.clone()], ..Path::default() })
            }
            _ => return false,
        };
        let is_own = |param: &TypeRef| match param {
            TypeRef::Path(_) => *param == owner,
            TypeRef::Reference { inner, .. } => **inner == owner,
            _ => false,
        };
        futures() == 1 && function.params.iter().filter(|param| is_own(param)).count() == 1
    }

    /// Whether a function polls the future that it is given: how far it gets is not known.
    pub(super) fn polls(&self, target: FunctionId, values: &[Value]) -> bool {
        let body = self.program.index.function(target).function.body.as_ref();
        let polls = |kind: &ExprKind| matches!(kind, ExprKind::MethodCall { method, .. } if method == "poll");
        let mut given = values.iter().enumerate();
        given.any(|(number, value)| self.is_future(value) || self.is_polled(value) && self.takes_any(target, number))
            && body.is_some_and(|body| body.exprs.iter().any(|expr| polls(&expr.kind)))
    }

    /// Whether a parameter of a function is of a type that its callers choose.
    fn takes_any(&self, target: FunctionId, number: usize) -> bool {
        let body = self.program.index.function(target).function.body.as_ref();
        let (Some(body), Some(typed)) = (body, self.program.typed(target)) else { return false };
        let local = body.params.get(number).and_then(|param| typed.pat_local.get(param));
        local.is_some_and(|local| matches!(future_behind(&typed.local(*local).ty), Ty::Param(_) | Ty::Opaque(_)))
    }

    /// Whether the body of the function that is called can be read.
    fn is_seen(&self, id: ExprId) -> bool {
        let has_body = |target: &FunctionId| self.program.index.function(*target).function.body.is_some();
        matches!(self.typed().callees.get(&id), Some(Callee::Resolved(resolved)) if resolved.targets.iter().any(has_body))
    }

    fn defer(&mut self, id: ExprId, call: Deferred) -> Value {
        self.deferred.insert((self.frame, id), call);
        self.future(id)
    }

    /// The future that an expression makes.
    pub(super) fn future(&mut self, id: ExprId) -> Value {
        let future = ClosureRef { frame: self.frame, expr: id };
        self.note_unrun(future, UnrunKind::Future, self.captured_to_update(future));
        Value { closure: Some(future), ..Value::default() }
    }

    /// Whether a value is a future that is known.
    pub(super) fn is_future(&self, value: &Value) -> bool {
        value.closure.is_some_and(|closure| self.is_of_future(closure))
    }

    pub(super) fn is_of_future(&self, future: ClosureRef) -> bool {
        let key = (future.frame, future.expr);
        let is_block = matches!(&self.frames[future.frame].body.expr(future.expr).kind, ExprKind::Block(_));
        let among = |choices: &Vec<ClosureRef>| choices.iter().any(|choice| self.is_of_future(*choice));
        is_block || self.deferred.contains_key(&key) || self.choices.get(&key).is_some_and(among)
    }

    /// What a value gives where it is awaited: what a known future does happens here.
    pub(super) fn awaited(&mut self, value: Value, span: Span) -> Value {
        match value.closure {
            Some(future) if self.is_of_future(future) => self.run_future(future, span),
            _ => value,
        }
    }

    /// Runs a future beside others, which run even if it never ends.
    pub(super) fn awaited_beside_others(&mut self, value: Value, span: Span) -> Value {
        if self.at.is_none() {
            return Value::default();
        }
        self.share_cells(&value);
        let before = self.emit(Effect::Nothing, span);
        let value = self.run_to_end(value, span);
        if self.at.is_none() {
            let after = self.add_node(Effect::Nothing, span);
            self.link(before, after);
            self.resume(after);
        }
        value
    }

    /// Runs what an `async` block or a call stands for.
    pub(super) fn run_future(&mut self, future: ClosureRef, span: Span) -> Value {
        self.note_run(future);
        if self.at.is_none() {
            return Value::default();
        }
        let body = self.frames[future.frame].body;
        let outer = std::mem::replace(&mut self.frame, future.frame);
        self.depth += 1;
        let value = match (&body.expr(future.expr).kind, self.deferred.get(&(future.frame, future.expr)).cloned()) {
            (ExprKind::Block(block), _) if block.kind == BlockKind::Async => {
                let (ty, at) = (self.ty(future.expr).clone(), self.span(future.expr));
                self.inline_body(ty, at, true, |this| this.plain_block(block, at))
            }
            (_, Some(Deferred::Function { resolved, exprs, values })) => {
                let value = self.resolved_call(future.expr, &resolved, &exprs, &values);
                // A function that runs the futures that it is given.
                if value.closure == Some(future) { self.run_future(future, span) } else { value }
            }
            (_, Some(Deferred::Closure { closure, values })) => {
                let value = self.inline_closure(closure, &values, span);
                self.awaited(value, span)
            }
            (_, Some(Deferred::Several { values, completes })) => self.run_several(future.expr, values, completes),
            (_, None) => match self.choices.get(&(future.frame, future.expr)).cloned() {
                Some(choices) => self.run_one_of(&choices, &[], span),
                None => Value::default(),
            },
        };
        self.depth -= 1;
        self.frame = outer;
        value
    }

    /// Runs one of several functions or closures, and which one is not known.
    pub(super) fn run_one_of(&mut self, choices: &[ClosureRef], args: &[Value], span: Span) -> Value {
        let join = self.new_join(Ty::Unknown, span);
        for (number, choice) in choices.iter().enumerate() {
            let mut next = None;
            if number + 1 < choices.len() && self.at.is_some() {
                let text = ONE_OF_SEVERAL.to_owned();
                let (this, other) = self.opaque_branch(span, text, crate::flow::About::default());
                self.resume(this);
                next = Some(other);
            }
            let value = self.inline_closure(*choice, args, span);
            self.end_branch(&join, &value, span);
            self.at = next;
        }
        self.close_join(&join)
    }

    fn run_several(&mut self, id: ExprId, values: Vec<Value>, completes: bool) -> Value {
        let span = self.span(id);
        if completes {
            for value in values {
                self.awaited_beside_others(value, span);
            }
            return Value::default();
        }
        let join = self.new_join(self.ty(id).clone(), span);
        for value in values {
            if !(self.is_future(&value) || self.is_polled(&value)) || self.at.is_none() {
                continue;
            }
            // Which of them ends first is not known, nor how far the others came.
            let about = crate::flow::About { is_event: true, ..self.about(id) };
            self.share_cells(&value);
            let (runs, dropped) = self.opaque_branch(span, self.text(id), about);
            let after = self.add_node(Effect::Nothing, span);
            self.resume(runs);
            self.run_to_end(value, span);
            self.jump(after);
            self.resume(dropped);
            self.jump(after);
            self.resume(after);
        }
        self.end_branch(&join, &Value::default(), span);
        self.close_join(&join)
    }

    /// The places that the call of a future was given, so that whatever that is handed to may change them; `None` if it is no call.
    pub(super) fn given_to_future(&self, future: ClosureRef) -> Option<Vec<Place>> {
        let of = |value: &Value| value.closure.map(|closure| self.captured(closure)).unwrap_or_default();
        match self.deferred.get(&(future.frame, future.expr))? {
            Deferred::Function { exprs, values, .. } => {
                let typed = self.frames[future.frame].typed;
                let holds = |expr: &ExprId| self.may_hold_filter(typed.ty(*expr));
                let given = exprs.iter().zip(values).filter(|(expr, _)| holds(expr));
                Some(given.flat_map(|(_, value)| value.place.clone().into_iter().chain(of(value))).collect())
            }
            Deferred::Closure { closure, .. } => Some(self.captured(*closure)),
            Deferred::Several { values, .. } => Some(values.iter().flat_map(of).collect()),
        }
    }

    /// `join!(a, b)`: each of them is run to its end.
    pub(super) fn joined(&mut self, id: ExprId, operands: &[ExprId]) -> Value {
        let span = self.span(id);
        let var = self.temporary(self.ty(id).clone(), span);
        for (number, operand) in operands.iter().enumerate() {
            let value = self.expr(*operand);
            let value = self.awaited_beside_others(value, span);
            self.place_part(Place::var(var).field(&number.to_string()), &value, *operand);
        }
        self.suspend(span);
        Value { place: Some(Place::var(var)), is_owned: true, ..Value::default() }
    }

    /// Whether a call of an `async fn`, or of its long form, is all that an expression is.
    pub(super) fn is_deferred(&self, id: ExprId) -> bool {
        matches!(self.typed().callees.get(&id), Some(Callee::Resolved(resolved)) if self.gives_future(resolved))
    }

    /// Whether a call gives a future and runs nothing by itself.
    fn gives_future(&self, resolved: &Resolved) -> bool {
        !resolved.targets.is_empty()
            && resolved.targets.iter().all(|target| {
                let function = &self.program.index.function(*target).function;
                function.is_async || self.is_long_form(*target)
            })
    }

    /// Whether all that a function does is to give back an `async` block: `fn step(&mut self) -> impl Future { async { … } }`.
    fn is_long_form(&self, id: FunctionId) -> bool {
        let Some(body) = &self.program.index.function(id).function.body else { return false };
        let mut at = body.root;
        loop {
            at = match &body.expr(at).kind {
                ExprKind::Block(block) if block.kind == BlockKind::Async => return true,
                ExprKind::Block(block) => match block.tail {
                    Some(tail) => tail,
                    None => return false,
                },
                ExprKind::Call { callee, args } => match (&body.expr(*callee).kind, args.as_slice()) {
                    (ExprKind::Path(path), [inner]) if matches!(path.last(), "pin" | "new") => *inner,
                    _ => return false,
                },
                ExprKind::MethodCall { receiver, method, .. } if keeps_future(method) => *receiver,
                _ => return false,
            };
        }
    }
}

/// Whether a function of this name runs all of the futures that it is given to their ends; `None` if it combines none.
fn combines(name: &str) -> Option<bool> {
    match name {
        "join" | "join3" | "join4" | "join5" | "join_array" | "join_all" | "try_join" | "try_join3"
        | "try_join_all" | "zip" => Some(true),
        "select" | "select3" | "select4" | "select_array" | "select_all" | "try_select" | "select_ok" | "race"
        | "or" | "timeout" | "timeout_at" | "with_timeout" | "with_deadline" => Some(false),
        _ => None,
    }
}

/// Whether a function of this name runs the future that it is given, and returns when that has ended.
pub(super) fn blocks_on(name: &str) -> bool {
    matches!(name, "block_on" | "run_until" | "spin_on" | "now_or_never" | "block_in_place")
}

/// Whether a method of this name gives the same future in another shape.
pub(super) fn keeps_future(name: &str) -> bool {
    matches!(
        name,
        "fuse" | "boxed" | "boxed_local" | "into_future" | "instrument" | "in_current_span" | "as_mut" | "shared"
    )
}
