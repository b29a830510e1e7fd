//! Calls of values of which the analysed code does not tell where they stand which closure they are: `(event.callback)(self)`.

use std::collections::BTreeSet;

use super::{Builder, ClosureRef, Frame, Value};
use crate::index::{FunctionId, TraitName, TraitRef, Ty};
use crate::syntax::tree::{ExprId, ExprKind, StmtKind};
use crate::types::{Callee, LocalId, Resolved};

impl Builder<'_> {
    /// Runs one of all closures and functions that may stand behind a called value, where it is lent a filter; `None` if they are not
    /// all known.
    pub(in crate::flow::lower) fn call_one_of_all(
        &mut self,
        id: ExprId,
        callee: ExprId,
        args: &[ExprId],
        values: &[Value],
    ) -> Option<Value> {
        let is_lent = |(arg, value): (&ExprId, &Value)| value.place.is_some() && self.may_hold_filter(self.ty(*arg));
        let is_plain = values.iter().all(|value| value.closure.is_none() && value.iterator.is_none());
        if self.at.is_none() || !is_plain || !args.iter().zip(values).any(is_lent) {
            return None;
        }
        let known = match self.typed().callees.get(&id) {
            Some(Callee::Parameter(local)) => match self.parameter_of(*local) {
                // What is called once in all is read where the function is called: `fn with(&mut self, f: impl FnOnce(&mut Bus))`.
                Some(_) if self.loops.is_empty() => return None,
                Some((function, number)) => self.program.callables.given_to(function, number)?,
                None => self.program.callables.behind(&self.typed().local(*local).ty.called_as()?.0)?,
            },
            // `fn spin(rig: &mut Rig, step: fn(&mut Rig) -> bool)`
            _ if let Some((function, number)) = self.pointer_parameter(callee) => {
                let known = self.program.callables.given_to(function, number).filter(|_| !self.loops.is_empty());
                known?
            }
            _ => self.program.callables.behind(&self.ty(callee).called_as()?.0)?,
        };
        // What one of them calls in turn may be any of them again.
        if known.iter().any(|(function, _)| self.inlining[1..].contains(function)) {
            return None;
        }
        self.lends_kept(id, &[], args, values);
        let frames = self.frames.len();
        let choices: Option<Vec<ClosureRef>> =
            known.iter().map(|(function, expr)| self.stand_apart(*function, *expr)).collect();
        let Some(choices) = choices else {
            self.frames.truncate(frames);
            return None;
        };
        let depth = self.inlining.len();
        self.inlining.extend(known.iter().map(|(function, _)| *function));
        self.run_one_of(&choices, values, self.span(id));
        self.inlining.truncate(depth);
        self.give_away(id, &[], args, values);
        Some(Value::default())
    }

    /// The closure that a function makes of what it is given, which its caller calls: `fn smoother(lag: Lag) -> impl FnMut(f32) -> f32`.
    pub(in crate::flow::lower) fn closure_made(
        &mut self,
        id: ExprId,
        resolved: &Resolved,
        values: &[Value],
    ) -> Option<Value> {
        let [target] = resolved.targets.as_slice() else { return None };
        let function = &self.program.index.function(*target).function;
        let body = function.body.as_ref().filter(|_| !function.is_async && !resolved.has_receiver)?;
        let mut last = body.root;
        while let ExprKind::Block(block) = &body.expr(last).kind {
            last = block.tail?;
        }
        let makes = matches!(&body.expr(last).kind, ExprKind::Closure(code) if code.is_move && !code.is_async);
        // One that is called once takes along what ends with that call, as a guard.
        let is_again = |bound: &TraitRef| {
            let TraitName::External(path) = &bound.name else { return false };
            path.ends_with("::Fn") || path.ends_with("::FnMut")
        };
        let is_opaque = matches!(self.ty(id), Ty::Opaque(bounds) if bounds.iter().any(is_again));
        let span = self.span(id);
        if makes && is_opaque && self.is_only_called(id) { self.inline_function(*target, values, span) } else { None }
    }

    /// Whether a value gets a name, and nothing is done with that but to call it.
    fn is_only_called(&self, value: ExprId) -> bool {
        let (body, typed) = (self.body(), self.typed());
        let name = body.blocks().flat_map(|block| &block.stmts).find_map(|stmt| match &stmt.kind {
            StmtKind::Let { pat, init: Some(init), .. } if *init == value => typed.pat_local.get(pat),
            _ => None,
        });
        let called: BTreeSet<ExprId> = body
            .exprs
            .iter()
            .filter_map(|expr| match &expr.kind {
                ExprKind::Call { callee, .. } => Some(*callee),
                _ => None,
            })
            .collect();
        name.is_some_and(|name| typed.expr_local.iter().all(|(named, local)| local != name || called.contains(named)))
    }

    /// The function of which a called pointer to a function is a parameter that stays what it is, and its number.
    fn pointer_parameter(&self, callee: ExprId) -> Option<(FunctionId, usize)> {
        let local = self.typed().expr_local.get(&callee)?;
        if !matches!(self.typed().local(*local).ty.peel(), Ty::Function(..)) {
            return None;
        }
        let stays =
            !self.frames[self.frame].given_anew.contains(local) && !self.frames[self.frame].mutated.contains(local);
        self.parameter_of(*local).filter(|_| stays)
    }

    /// The function of which a local is a parameter, and its number.
    fn parameter_of(&self, local: LocalId) -> Option<(FunctionId, usize)> {
        let mut params = self.body().params.iter();
        let number = params.position(|pat| self.typed().pat_local.get(pat) == Some(&local))?;
        Some((self.program.index.origin(self.frames[self.frame].function), number))
    }

    /// A closure or function as it stands in another body, whose variables have no names here: what a closure captures is judged
    /// where it is made.
    fn stand_apart(&mut self, function: FunctionId, expr: ExprId) -> Option<ClosureRef> {
        let body = self.program.index.function(function).function.body.as_ref()?;
        let typed = self.program.typed(function)?;
        let span = body.expr(expr).span;
        self.frames.push(Frame::new(function, body, typed));
        let frame = self.frames.len() - 1;
        let named = typed.expr_local.iter().filter(|(named, _)| span.contains(body.expr(**named).span));
        let locals: BTreeSet<LocalId> = named.map(|(_, local)| *local).collect();
        for local in locals {
            let info = typed.local(local);
            if !span.contains(info.span) {
                let hidden = self.temporary(info.ty.clone(), info.span);
                self.frames[frame].vars.insert(local, hidden);
            }
        }
        Some(ClosureRef { frame, expr })
    }
}
