//! Names of numbers that are borrowed by `&mut` for a while: as long as they are used, what they name has no other name. So they
//! stand for its place: `let Self { divider, .. } = self;`, `let count = &mut self.count;`, `let local = cx.local;`.

use super::Builder;
use crate::flow::{IndexKey, Place, Projection, Var};
use crate::index::{Def, Ty};
use crate::syntax::tree::{ExprId, ExprKind, PatId, PatKind};

impl Builder<'_> {
    /// Lets the names that a `let` binds to borrowed places stand for these.
    pub(super) fn note_lent_names(&mut self, pat: PatId, init: ExprId) {
        let body = self.body();
        if let (PatKind::Tuple(pats), ExprKind::Tuple(parts)) = (&body.pat(pat).kind, &body.expr(init).kind)
            && pats.len() == parts.len()
        {
            for (pat, part) in pats.iter().zip(parts) {
                self.note_lent_names(*pat, *part);
            }
            return;
        }
        if let Some(place) = self.lent_place(init)
            && self.stand_for(pat, &place)
        {
            self.frames[self.frame].passed.insert(init);
        }
    }

    /// A place whose name means the same as long as something of it is borrowed: in an element, if a parameter numbers it.
    fn lent_place(&mut self, init: ExprId) -> Option<Place> {
        let place = self.static_place(init)?;
        let is_kept = |var: Var| !self.is_assigned(var);
        let is_given = |var: Var| self.graph.var(var).param.is_some() && is_kept(var);
        let is_same = |step: &Projection| match step {
            Projection::Field(_) => true,
            step => matches!(step.key(), Some(IndexKey::Var(number)) if is_given(*number)),
        };
        (place.base_var().is_none_or(is_kept) && place.steps.iter().all(is_same)).then_some(place)
    }

    /// Whether some name of a pattern now stands for its part of a place.
    fn stand_for(&mut self, pat: PatId, place: &Place) -> bool {
        let body = self.body();
        match &body.pat(pat).kind {
            PatKind::Bind { sub: None, .. } => {
                let Some(local) = self.typed().pat_local.get(&pat).copied() else { return false };
                let frame = &self.frames[self.frame];
                if frame.mutated.contains(&local) || frame.given_anew.contains(&local) {
                    return false;
                }
                let ty = &self.typed().local(local).ty;
                let is_lent = matches!(ty, Ty::Ref(true, inner) if !matches!(**inner, Ty::Ref(..)));
                let is_cell = matches!(ty, Ty::Ref(false, inner) if inner.external_name() == Some("Cell"))
                    && !self.may_hold_filter(ty.peel());
                let is_number = is_cell || is_lent && matches!(ty.peel(), Ty::Int | Ty::Float | Ty::Bool);
                let holds_filter = self.may_hold_filter(ty.peel());
                let frame = &mut self.frames[self.frame];
                if is_number {
                    frame.stand_ins.insert(local, place.clone());
                } else if holds_filter {
                    // The names of the filters themselves are followed elsewhere.
                    frame.owners.insert(local, (place.clone(), is_lent));
                }
                is_number
            }
            PatKind::Struct(_, fields) if !matches!(self.typed().pat_def.get(&pat), Some(Def::Variant(..))) => {
                let stand_for = |(name, inner): &(String, PatId)| self.stand_for(*inner, &place.field(name));
                fields.iter().map(stand_for).fold(false, |any, stands| any | stands)
            }
            _ => false,
        }
    }

    /// The place of a field without a filter whose owner has another name: `local.divider` after `let local = cx.local;`, where
    /// that is a reference, and `this.divider` after `let this = &mut *self;`.
    pub(super) fn field_of_other_name(&self, base: ExprId, name: &str) -> Option<Place> {
        if self.frames[self.frame].owners.is_empty() {
            return None;
        }
        let ty = self.program.index.field_ty(self.ty(base).peel(), None, name)?;
        let (place, is_lent) = self.other_name(base)?;
        let is_same = is_lent || matches!(ty, Ty::Ref(true, _));
        (is_same && !self.may_hold_filter(&ty)).then(|| place.field(name))
    }

    fn other_name(&self, id: ExprId) -> Option<(Place, bool)> {
        match &self.body().expr(id).kind {
            ExprKind::Path(_) => {
                let local = self.typed().expr_local.get(&id)?;
                self.frames[self.frame].owners.get(local).cloned()
            }
            ExprKind::Field { base, name } => {
                let (place, is_lent) = self.other_name(*base)?;
                Some((place.field(name), is_lent || matches!(self.ty(id), Ty::Ref(true, _))))
            }
            ExprKind::Deref(inner) => self.other_name(*inner),
            _ => None,
        }
    }
}
