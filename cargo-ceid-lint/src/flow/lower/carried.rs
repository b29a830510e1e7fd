//! What iterators carry from round to round, where that may hold filters: the state of `scan`, and what `fold` goes on with.

use super::{Builder, Value};
use crate::flow::{Assignment, Effect, Place, Var};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::ExprId;

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
