//! What iterators carry from round to round, where that may hold filters: the state of `scan`, and what `fold` goes on with.

use super::{Builder, ClosureRef, Value};
use crate::flow::{Assignment, Effect, Place, Var};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind};

/// The first argument of a consumer's closure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    /// An item.
    None,
    /// What the round before gave; in a variable if it may hold filters.
    Carried(Option<Var>),
}

impl State {
    pub(super) fn var(self) -> Option<Var> {
        match self {
            Self::None => None,
            Self::Carried(var) => var,
        }
    }
}

impl Builder<'_> {
    /// The variable that what the first round begins with moves into, if it may hold filters.
    pub(super) fn carried(&mut self, first: ExprId, value: &Value) -> Option<Var> {
        let ty = self.ty(first).clone();
        if self.at.is_none() || !self.may_hold_filter(&ty) {
            return None;
        }
        let span = self.span(first);
        let var = self.temporary(ty, span);
        self.set(var, value, span);
        Some(var)
    }

    /// What a closure goes on with is computed from what `fold` began with: `stages.iter_mut().fold(*sample, |value, stage| stage.run(value))`.
    pub(super) fn derive_begun(&mut self, consumer: ExprId, closure: ClosureRef) {
        let ExprKind::MethodCall { args, .. } = &self.body().expr(consumer).kind else { return };
        let ([first, _], frame) = (args.as_slice(), &self.frames[closure.frame]) else { return };
        let bound = self.param_of(closure).and_then(|pat| frame.typed.pat_local.get(&pat));
        let var = bound.and_then(|local| frame.vars.get(local)).copied();
        self.derive(var.as_slice(), *first);
    }

    /// What a closure of a chain is given is computed as the one before makes it: `samples.map(|x| x * GAIN).map(|x| filter.update(x))`.
    pub(super) fn derive_made(&mut self, made_by: ClosureRef, closure: ClosureRef) {
        let Some(pat) = self.param_of(closure) else { return };
        let ExprKind::Closure(code) = &self.frames[made_by.frame].body.expr(made_by.expr).kind else { return };
        let outer = std::mem::replace(&mut self.frame, closure.frame);
        let given = self.vars_of(pat);
        self.frame = made_by.frame;
        self.derive(&given, code.body);
        self.frame = outer;
    }

    /// What a round gives is what the next one begins with.
    pub(super) fn carry_on(&mut self, state: Var, value: &Value, span: Span) {
        let ty = self.graph.var(state).ty.clone();
        if self.at.is_none() {
            return;
        }
        if matches!(ty, Ty::Ref(..)) {
            self.set(state, value, span);
            return;
        }
        let assignment = Assignment {
            place: Place::var(state),
            from: value.place.clone(),
            transfer: self.transfer(value, &ty),
            rebinds: false,
            head: None,
            same_as: None,
        };
        self.emit(Effect::Write(Box::new(assignment)), span);
    }
}
