//! Which of the methods of one name is called: that of a trait in scope, in the order in which the compiler looks for them.

use super::infer::Infer;
use crate::index::{MethodOwner, Ty};
use crate::syntax::tree::{ExprId, Receiver};

/// What a method gets as `self`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// The value itself.
    Value,
    /// A shared reference to it.
    Shared,
    /// An exclusive reference to it.
    Exclusive,
}

impl Form {
    /// That of a reference.
    pub(super) fn of_reference(mutable: bool) -> Self {
        if mutable { Self::Exclusive } else { Self::Shared }
    }

    /// How early the compiler looks for a method that gets this, where the receiver is such a value: as it is, behind a shared
    /// reference, behind an exclusive one, and then the same with what the receiver refers to.
    fn rank(self, receiver: Self) -> u8 {
        match (receiver, self) {
            (Self::Value, Self::Value) | (Self::Shared, Self::Shared) | (Self::Exclusive, Self::Exclusive) => 0,
            (Self::Value, Self::Shared) => 1,
            (Self::Value, Self::Exclusive) => 2,
            (Self::Shared | Self::Exclusive, Self::Value) => 3,
            (Self::Exclusive, Self::Shared) => 4,
            (Self::Shared, Self::Exclusive) => 5,
        }
    }
}

impl Infer<'_> {
    /// The method that is called on a type, with the type that it belongs to: the type itself, or a reference to it.
    pub(super) fn probed(
        &self,
        ty: &Ty,
        receiver: Form,
        method: &str,
        args: &[ExprId],
        owners: Vec<MethodOwner>,
    ) -> Option<(MethodOwner, Ty)> {
        let mut candidates: Vec<(MethodOwner, Ty)> = owners.into_iter().map(|owner| (owner, ty.clone())).collect();
        // Of a type that only bounds tell, all that the bounds have is in scope.
        // What a type of the standard library can do is not all known here.
        if !matches!(ty, Ty::Adt(..)) && (candidates.is_empty() || !matches!(ty, Ty::External(..))) {
            return candidates.into_iter().next();
        }
        for mutable in [false, true] {
            let lent = Ty::Ref(mutable, Box::new(ty.clone()));
            let is_found =
                |owner: &MethodOwner| takes(self, owner) == Some(Form::Value) && !self.is_out_of_scope(owner);
            let of_reference = self.extension(&lent, method, args).filter(is_found);
            candidates.extend(of_reference.map(|owner| (owner, lent)));
        }
        // What it dereferences to has the method, if it has none itself that is in scope.
        if candidates.iter().all(|(owner, _)| self.is_out_of_scope(owner))
            && let Some((target, _)) = self.user_deref(ty)
            && !self.methods_of(target.peel(), method).is_empty()
        {
            return None;
        }
        if candidates.len() > 1 {
            self.leave_in_scope(&mut candidates);
        }
        if candidates.len() > 1 {
            let rank = |(owner, of): &(MethodOwner, Ty)| self.rank_of(owner, of, receiver);
            // Where one of them cannot be told, the type's own methods go first.
            if let Some(ranks) = candidates.iter().map(rank).collect::<Option<Vec<_>>>() {
                let first = (0..candidates.len()).min_by_key(|at| ranks[*at])?;
                return Some(candidates.swap_remove(first));
            }
        }
        candidates.into_iter().next()
    }

    /// Leaves of methods those that can be meant: what is no method, and what a trait has that is not in scope, is not.
    fn leave_in_scope(&self, candidates: &mut Vec<(MethodOwner, Ty)>) {
        let can_be_meant = |(owner, _): &(MethodOwner, Ty)| {
            let is_function = owner.function().is_some_and(|id| self.index.function(id).function.receiver.is_none());
            !is_function && !self.is_out_of_scope(owner)
        };
        if candidates.iter().any(can_be_meant) {
            candidates.retain(can_be_meant);
        }
    }

    /// Those of the functions of a type that can be meant by its path: `Rig::step`.
    pub(super) fn in_scope_here(&self, mut owners: Vec<MethodOwner>) -> Vec<MethodOwner> {
        if owners.len() > 1 && !owners.iter().all(|owner| self.is_out_of_scope(owner)) {
            owners.retain(|owner| !self.is_out_of_scope(owner));
        }
        owners
    }

    fn is_out_of_scope(&self, owner: &MethodOwner) -> bool {
        owner.of_trait().is_some_and(|name| self.index.is_in_scope(self.module(), name) == Some(false))
    }

    /// How early the compiler finds a method: by what it gets, and then by whose it is. `None` if that is not known.
    fn rank_of(&self, owner: &MethodOwner, of: &Ty, receiver: Form) -> Option<(u8, bool)> {
        let is_of_trait = match owner.of_trait() {
            Some(name) => {
                self.index.is_in_scope(self.module(), name).filter(|is_there| *is_there)?;
                true
            }
            None => false,
        };
        let form = match of {
            Ty::Ref(mutable, _) => Form::of_reference(*mutable),
            _ => takes(self, owner)?,
        };
        Some((form.rank(receiver), is_of_trait))
    }
}

/// What a method gets as `self`, of the type that it is written for.
fn takes(infer: &Infer<'_>, owner: &MethodOwner) -> Option<Form> {
    match &infer.index.function(owner.function()?).function.receiver {
        Some(Receiver::Value) => Some(Form::Value),
        Some(Receiver::Shared) => Some(Form::Shared),
        Some(Receiver::Exclusive) => Some(Form::Exclusive),
        Some(Receiver::Typed(_)) | None => None,
    }
}
