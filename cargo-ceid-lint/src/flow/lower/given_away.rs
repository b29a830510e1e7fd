//! Guards that go where they are not followed: a call that gets one by value may drop it, or keep it for longer than the cycle.

use rustc_hash::FxHashSet;

use super::calls::path_tail;
use super::{Builder, ClosureRef, Value};
use crate::flow::{Cause, Effect, GuardId, Place, Var};
use crate::index::{FunctionId, Ty};
use crate::syntax::tree::{ExprId, ExprKind, PatKind, Receiver, TypeRef};
use crate::types::Callee;

/// How many calls a guard is followed through to where it is dropped.
const MAX_CALLS: u32 = 4;

impl Builder<'_> {
    /// A call of what is declared in an `extern` block, whose body is somewhere else. It may keep what it gets a raw pointer to.
    pub(super) fn extern_call(
        &mut self,
        id: ExprId,
        targets: &[FunctionId],
        exprs: &[ExprId],
        values: &[Value],
    ) -> Value {
        let index = self.program.index;
        let is_pointer = |number: usize| {
            let param = |target: &FunctionId| index.function(*target).function.params.get(number);
            targets.iter().filter_map(param).any(|ty| matches!(ty, TypeRef::Pointer(_)))
        };
        let pointed = exprs.iter().zip(values).enumerate().filter(|(number, _)| is_pointer(*number));
        let places: Vec<Place> = pointed
            .filter(|(_, (expr, _))| self.may_hold_filter(self.ty(**expr)))
            .filter_map(|(_, (_, value))| value.place.clone())
            .collect();
        let cause = Cause::Call(self.text(id));
        self.graph.kept.extend(places.into_iter().map(|place| (place, cause.clone())));
        self.unknown_call(id, self.text(id), exprs, values)
    }

    /// A call has got guards by value: the functions that it may run drop them, or what becomes of them is not known.
    pub(super) fn give_away(&mut self, id: ExprId, targets: &[FunctionId], exprs: &[ExprId], values: &[Value]) {
        for (number, (expr, value)) in exprs.iter().zip(values).enumerate() {
            let is_lent = || self.is_receiver(id, *expr) && !self.takes_receiver(targets);
            // What a function drops takes long to find out, and few values are guards.
            let drops_itself = || !targets.is_empty() && self.destroyed_by(value).is_some();
            if !self.goes_by_value(*expr, value) || is_lent() || drops_itself() {
                continue;
            }
            if !targets.is_empty() && targets.iter().all(|target| self.drops(*target, number, 0)) {
                let how = format!("`{}` drops it here", self.called_name(id));
                self.drop_value(id, *expr, value, &how);
            } else {
                self.lose_guard(id, *expr, value);
            }
        }
    }

    /// A variable, collection or channel has got a guard: one that is declared beside the guard keeps it no longer than the
    /// cycle.
    pub(super) fn put_away(&mut self, id: ExprId, owner: &Place, exprs: &[ExprId], values: &[Value]) {
        for (expr, value) in exprs.iter().zip(values) {
            let Some(guard) = self.moved_guard(value) else {
                self.keep_destructor(*expr, value);
                continue;
            };
            let in_loop = self.graph.guards[guard.0 as usize].in_loop;
            let ends_with_it =
                |base: Var| self.graph.var(base).in_loop == in_loop && self.graph.var(base).param.is_none();
            let is_destructor = self.graph.guards[guard.0 as usize].is_destructor;
            if is_destructor || !owner.base_var().is_some_and(ends_with_it) {
                self.lose_guard(id, *expr, value);
            }
        }
    }

    /// A closure that takes what it names goes where it is not followed, or to another thread.
    pub(super) fn lose_captured(&mut self, id: ExprId, closure: ClosureRef) {
        let ExprKind::Closure(code) = &self.frames[closure.frame].body.expr(closure.expr).kind else { return };
        if !code.is_move || self.at.is_none() {
            return;
        }
        for var in self.captured_vars(closure) {
            let value = Value { place: Some(Place::var(var)), is_owned: true, ..Value::default() };
            if let Some(guard) = self.moved_guard(&value) {
                self.lose(id, guard);
            }
        }
    }

    fn goes_by_value(&self, expr: ExprId, value: &Value) -> bool {
        self.at.is_some() && !matches!(self.ty(expr), Ty::Ref(..)) && self.moved_guard(value).is_some()
    }

    /// What becomes of a guard is not known, nor whether it ever ends.
    fn lose_guard(&mut self, id: ExprId, expr: ExprId, value: &Value) {
        if let Some(guard) = self.moved_guard(value).filter(|_| self.goes_by_value(expr, value)) {
            self.lose(id, guard);
        }
    }

    pub(super) fn lose(&mut self, id: ExprId, guard: GuardId) {
        let span = self.span(id);
        let places = self.graph.guards[guard.0 as usize].holds.iter().copied().map(Place::var).collect();
        let cause = Cause::Code("where its guard goes".to_owned());
        self.emit(Effect::Unknown { places, cause }, span);
        if self.graph.guards[guard.0 as usize].is_destructor {
            return self.release(guard, span);
        }
        self.let_go(guard, span);
        self.end_now(guard, span);
    }

    pub(super) fn is_receiver(&self, id: ExprId, expr: ExprId) -> bool {
        matches!(&self.body().expr(id).kind, ExprKind::MethodCall { receiver, .. } if *receiver == expr)
    }

    fn takes_receiver(&self, targets: &[FunctionId]) -> bool {
        let by_value =
            |target: &FunctionId| self.program.index.function(*target).function.receiver == Some(Receiver::Value);
        targets.iter().any(by_value)
    }

    /// Whether a function is seen to drop a parameter: nothing in it takes the parameter's value but what drops it.
    fn drops(&self, target: FunctionId, number: usize, depth: u32) -> bool {
        let function = &self.program.index.function(target).function;
        let (Some(body), Some(typed)) = (&function.body, self.program.typed(target)) else { return false };
        let Some(pat) = body.params.get(number).filter(|_| depth < MAX_CALLS && !function.is_async) else {
            return false;
        };
        if matches!(body.pat(*pat).kind, PatKind::Wild) {
            return true;
        }
        let Some(local) = typed.pat_local.get(pat) else { return false };
        let mut lent = FxHashSet::default();
        for (at, expr) in (0u32..).map(ExprId).zip(&body.exprs) {
            match &expr.kind {
                ExprKind::Reference { value, .. } => lent.extend([*value]),
                ExprKind::Field { base, .. } => lent.extend([*base]),
                ExprKind::MethodCall { receiver, .. } => {
                    let is_lent = match typed.callees.get(&at) {
                        Some(Callee::Resolved(resolved)) if !resolved.targets.is_empty() => {
                            !self.takes_receiver(&resolved.targets)
                        }
                        // No method of ceid-core's guard takes it.
                        _ => self.is_ceid(typed.ty(*receiver), "CycleGuard"),
                    };
                    lent.extend(is_lent.then_some(*receiver));
                }
                ExprKind::Call { args, .. } => match typed.callees.get(&at) {
                    Some(Callee::External(path)) if path_tail(path) == "mem::drop" => lent.extend(args),
                    Some(Callee::Resolved(resolved)) if !resolved.targets.is_empty() => {
                        let is_dropped = |number: usize| {
                            resolved.targets.iter().all(|target| self.drops(*target, number, depth + 1))
                        };
                        lent.extend(args.iter().enumerate().filter(|(at, _)| is_dropped(*at)).map(|(_, arg)| arg));
                    }
                    _ => {}
                },
                _ => {}
            }
        }
        let captures: Vec<_> =
            body.exprs.iter().filter(|expr| matches!(expr.kind, ExprKind::Closure(_))).map(|expr| expr.span).collect();
        typed.expr_local.iter().filter(|(_, own)| *own == local).all(|(at, _)| {
            let span = body.expr(*at).span;
            lent.contains(at) && !captures.iter().any(|closure| closure.contains(span))
        })
    }
}
