//! States inside of what is assigned anew: after `runner = Runner::new()` the phase is the one that the constructor writes.

use super::Builder;
use super::constants::Constants;
use crate::flow::{Assignment, Effect, Head, Place, Transfer, Var};
use crate::index::{Def, Ty};
use crate::source::Span;
use crate::syntax::tree::{Body, ExprId, ExprKind};

impl Builder<'_> {
    /// A place has got a new value: the states in it are known as far as the code that makes the value writes them.
    pub(super) fn renew_states(&mut self, target: ExprId, value: ExprId, span: Span) {
        if self.at.is_none() || !matches!(self.ty(target), Ty::Adt(..) | Ty::Tuple(_)) {
            return;
        }
        let states = self.made_states(value);
        let Some(whole) = self.static_place(target).filter(|_| !states.is_empty()) else { return };
        for (name, head) in states {
            let written = Assignment {
                place: whole.field(&name),
                from: None,
                transfer: Transfer::Move,
                rebinds: false,
                head: Some(head),
                same_as: None,
            };
            self.emit(Effect::Write(Box::new(written)), span);
        }
    }

    /// A variable has got what a constructor makes: whether something is in its options of references is known as far as the code there
    /// writes it.
    pub(super) fn made_options(&mut self, var: Var, value: ExprId, span: Span) {
        let is_call = matches!(self.body().expr(value).kind, ExprKind::Call { .. });
        if !is_call || !matches!(self.ty(value), Ty::Adt(..)) || !self.program.index.refers_to_filters(self.ty(value)) {
            return;
        }
        for (name, head) in self.made_with(value, &|ty| self.is_option_of_references(ty)) {
            let place = Place::var(var).field(&name);
            // What it refers to has come with the whole.
            let from = Some(place.clone());
            let given =
                Assignment { place, from, transfer: Transfer::Borrow, rebinds: true, head: Some(head), same_as: None };
            self.emit(Effect::Set(Box::new(given)), span);
        }
    }

    /// The fields of a struct or tuple that are states, with the heads that its literal gives them: here, or at the end of the function that
    /// is called.
    fn made_states(&self, value: ExprId) -> Vec<(String, Head)> {
        self.made_with(value, &|ty| self.is_state(ty))
    }

    fn made_with(&self, value: ExprId, is_asked: &dyn Fn(&Ty) -> bool) -> Vec<(String, Head)> {
        let here = self.constants();
        if matches!(here.body.expr(value).kind, ExprKind::Struct { .. } | ExprKind::Tuple(_)) {
            return written(here, value, is_asked);
        }
        let Some(target) = self.only_target(value) else { return Vec::new() };
        let function = &self.program.index.function(target).function;
        let (Some(body), Some(typed)) = (&function.body, self.program.typed(target)) else { return Vec::new() };
        if function.is_async || may_end_early(body) {
            return Vec::new();
        }
        let mut at = body.root;
        while let ExprKind::Block(block) = &body.expr(at).kind {
            let Some(tail) = block.tail else { return Vec::new() };
            at = tail;
        }
        written(Constants { program: self.program, body, typed }, at, is_asked)
    }
}

/// The fields of a literal whose types are asked for, with the heads that they are given.
fn written(of: Constants<'_>, literal: ExprId, is_asked: &dyn Fn(&Ty) -> bool) -> Vec<(String, Head)> {
    let parts: Vec<(String, ExprId)> = match &of.body.expr(literal).kind {
        ExprKind::Struct { fields, .. } => fields.clone(),
        ExprKind::Tuple(parts) => parts.iter().enumerate().map(|(at, part)| (at.to_string(), *part)).collect(),
        _ => return Vec::new(),
    };
    // The fields of a variant lie behind its name.
    if matches!(of.typed.expr_def.get(&literal), Some(Def::Variant(..))) {
        return Vec::new();
    }
    let asked = parts.into_iter().filter(|(_, field)| is_asked(of.typed.ty(*field)));
    asked.filter_map(|(name, field)| Some((name, of.head(field)?))).collect()
}

/// Whether a function may give back something else than what stands at its end.
fn may_end_early(body: &Body) -> bool {
    let ends = |kind: &ExprKind| matches!(kind, ExprKind::Return(_) | ExprKind::Try(_) | ExprKind::Break { .. });
    body.exprs.iter().any(|expr| ends(&expr.kind) || matches!(expr.kind, ExprKind::Opaque(_)))
}
