//! Values with destructors of which a pattern takes only a part by value, or nothing: what is left has no name, and is dropped where
//! its statement or its scope ends.

use super::super::{Builder, Value};
use crate::flow::Place;
use crate::index::{Def, Shape, Ty};
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, PatId, PatKind};

/// What a pattern leaves of a value, of what something runs where it is dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Left {
    Nothing,
    Whole,
    Parts,
}

impl Left {
    fn of_parts(parts: impl Iterator<Item = Self>) -> Self {
        let mut parts: Vec<Self> = parts.collect();
        parts.dedup();
        match parts.as_slice() {
            [] => Self::Nothing,
            [all] => *all,
            _ => Self::Parts,
        }
    }
}

impl Builder<'_> {
    /// What `let` leaves of a value that was made for it: dropped at once, unless a reference to it is bound.
    pub(in crate::flow::lower) fn leave_by_let(&mut self, pat: PatId, init: ExprId, value: &Value, span: Span) {
        match self.left_of_made(pat, init, value) {
            Left::Nothing => {}
            _ if self.binds_by_reference(pat) => self.hold_unnamed(init, value, span),
            Left::Whole if !self.is_guard_value(init, value) => self.drop_now(init, value, span),
            _ => self.lose_left(init, value, span),
        }
    }

    /// The same of what is matched: it lives to the end of the arm.
    pub(in crate::flow::lower) fn leave_by_arm(&mut self, pat: PatId, scrutinee: ExprId, value: &Value, span: Span) {
        match self.left_of_made(pat, scrutinee, value) {
            Left::Nothing => {}
            Left::Whole => self.hold_unnamed(scrutinee, value, span),
            Left::Parts => self.lose_left(scrutinee, value, span),
        }
    }

    /// The same of what a condition asks: where it does not match, another variant may be dropped.
    pub(in crate::flow::lower) fn leave_by_condition(&mut self, pat: PatId, asked: ExprId, value: &Value, span: Span) {
        let is_of_other = || !self.is_irrefutable(pat) && !self.asks_for_presence(pat);
        let left = self.left_of_made(pat, asked, value);
        if left != Left::Nothing || is_of_other() && self.is_made_for(asked, value) && self.is_dropped(self.ty(asked)) {
            self.lose_left(asked, value, span);
        }
    }

    /// What an iterator takes by value is dropped by its rounds, or behind them.
    pub(in crate::flow::lower) fn lose_iterated(&mut self, iterated: ExprId, places: Vec<Place>) {
        let ty = self.ty(iterated).clone();
        if self.at.is_some() && self.is_dropped(&ty) {
            let item = crate::types::item_of(&ty).unwrap_or(ty);
            for place in places {
                self.drop_unseen(&item, place, self.span(iterated));
            }
        }
    }

    /// A value that has no name lives to the end of the innermost scope.
    fn hold_unnamed(&mut self, expr: ExprId, value: &Value, span: Span) {
        if self.is_guard_value(expr, value) {
            return self.lose_left(expr, value, span);
        }
        let held = self.temporary(self.ty(expr).clone(), span);
        self.set(held, value, span);
        self.bind_destructor(held, value, span);
    }

    /// When something of a value is dropped is not known.
    fn lose_left(&mut self, expr: ExprId, value: &Value, span: Span) {
        if self.at.is_none() {
            return;
        }
        if self.is_guard_value(expr, value) {
            if let Some(guard) = self.guard_of(expr, value) {
                self.lose(expr, guard);
            }
        } else if let Some(place) = value.place.clone() {
            self.drop_unseen(&self.ty(expr).clone(), place, span);
        }
    }

    fn left_of_made(&self, pat: PatId, expr: ExprId, value: &Value) -> Left {
        if self.is_made_for(expr, value) { self.left_by(pat, self.ty(expr)) } else { Left::Nothing }
    }

    /// Whether a value was made by an expression, and nothing else drops it.
    fn is_made_for(&self, expr: ExprId, value: &Value) -> bool {
        let is_place = matches!(
            self.body().expr(expr).kind,
            ExprKind::Path(_) | ExprKind::Field { .. } | ExprKind::Index { .. } | ExprKind::Deref(_)
        );
        let is_held = || self.destroyed_by(value).is_some() || self.is_guard_value(expr, value) && self.is_bound(value);
        self.at.is_some() && value.is_owned && !is_place && !is_held()
    }

    /// Whether something runs where a value of a type is dropped.
    pub(in crate::flow::lower) fn is_dropped(&self, ty: &Ty) -> bool {
        !matches!(ty, Ty::Ref(..)) && (self.has_destructor(ty) || self.has_guard(ty, 0))
    }

    fn left_by(&self, pat: PatId, ty: &Ty) -> Left {
        if !self.is_dropped(ty) {
            return Left::Nothing;
        }
        let typed = self.typed();
        let is_whole = |ty: &Ty| self.is_guard_ty(ty) && !matches!(ty, Ty::External(..));
        match &self.body().pat(pat).kind {
            PatKind::Bind { by_ref: false, sub: None, .. } if !typed.pat_def.contains_key(&pat) => Left::Nothing,
            PatKind::Wild | PatKind::Rest | PatKind::Bind { .. } | PatKind::Path(_) => Left::Whole,
            PatKind::Tuple(pats) => match ty {
                Ty::Tuple(parts) if parts.len() == pats.len() => {
                    let parts = pats.iter().zip(parts).filter(|(_, part)| self.is_dropped(part));
                    Left::of_parts(parts.map(|(pat, part)| self.left_by(*pat, part)))
                }
                _ => Left::Parts,
            },
            PatKind::TupleStruct(path, pats) => match (ty, pats.as_slice()) {
                (Ty::External(_, args), [inner]) => {
                    let number = usize::from(path.last() == "Err");
                    args.get(number).map_or(Left::Parts, |content| self.left_by(*inner, content))
                }
                _ if is_whole(ty) => Left::Whole,
                (Ty::Adt(..), pats) => {
                    let named = pats.iter().enumerate().map(|(number, pat)| (number.to_string(), *pat));
                    self.left_by_fields(pat, ty, &named.collect::<Vec<_>>())
                }
                _ => Left::Parts,
            },
            PatKind::Struct(_, fields) if !is_whole(ty) => self.left_by_fields(pat, ty, fields),
            _ => Left::Parts,
        }
    }

    fn left_by_fields(&self, pat: PatId, ty: &Ty, pats: &[(String, PatId)]) -> Left {
        let Ty::Adt(id, _) = ty else { return Left::Parts };
        let index = self.program.index;
        let (variant, fields) = match (&index.type_def(*id).shape, self.typed().pat_def.get(&pat)) {
            // Nothing is moved out of what has a destructor.
            _ if self.own_destructor(ty).is_some() => return Left::Whole,
            (Shape::Struct(fields), _) => (None, fields),
            (Shape::Enum(variants), Some(Def::Variant(_, at))) => match variants.get(*at) {
                Some(variant) => (Some(*at), &variant.fields),
                None => return Left::Parts,
            },
            _ => return Left::Parts,
        };
        let left = fields.fields.iter().filter_map(|field| {
            let ty = index.field_ty(ty, variant, &field.name).filter(|ty| self.is_dropped(ty))?;
            let pat = pats.iter().find(|(name, _)| *name == field.name);
            Some(pat.map_or(Left::Whole, |(_, pat)| self.left_by(*pat, &ty)))
        });
        Left::of_parts(left)
    }

    /// Whether a pattern asks whether there is something: `Some(guard)`, `Ok(guard)`.
    fn asks_for_presence(&self, pat: PatId) -> bool {
        matches!(&self.body().pat(pat).kind, PatKind::TupleStruct(path, _) if matches!(path.last(), "Some" | "Ok"))
    }

    fn binds_by_reference(&self, pat: PatId) -> bool {
        let body = self.body();
        match &body.pat(pat).kind {
            PatKind::Bind { by_ref, .. } => *by_ref,
            PatKind::Tuple(pats) | PatKind::TupleStruct(_, pats) | PatKind::Slice(pats) | PatKind::Or(pats) => {
                pats.iter().any(|pat| self.binds_by_reference(*pat))
            }
            PatKind::Struct(_, fields) => fields.iter().any(|(_, pat)| self.binds_by_reference(*pat)),
            _ => false,
        }
    }
}
