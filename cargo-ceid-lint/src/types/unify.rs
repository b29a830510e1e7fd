//! Variables of the inference and what they stand for. Lenient: a mismatch is ignored, because the compiler reports it.

use rustc_hash::FxHashMap;

use super::unread::Origin;
use crate::index::Ty;

/// The variables of one body.
#[derive(Debug, Default)]
pub(super) struct Variables {
    bound: Vec<Option<Ty>>,
    /// Those that stand for what unread code of a filter gave.
    origins: FxHashMap<u32, Origin>,
}

/// How deep types are compared: more is a type that contains itself.
const MAX_DEPTH: u32 = 24;

impl Variables {
    pub(super) fn fresh(&mut self) -> Ty {
        self.bound.push(None);
        Ty::Var(u32::try_from(self.bound.len() - 1).expect("fewer than 2^32 variables"))
    }

    /// A variable for what unread code of a filter gave.
    pub(super) fn fresh_of(&mut self, origin: Origin) -> Ty {
        let made = self.fresh();
        if let Ty::Var(id) = made {
            self.origins.insert(id, origin);
        }
        made
    }

    /// Where a value comes from whose type is still open.
    pub(super) fn origin(&self, ty: &Ty) -> Option<&Origin> {
        let Ty::Var(id) = self.shallow(ty) else { return None };
        self.origins.get(&id)
    }

    /// The type with its outermost variable replaced, if it is bound.
    pub(super) fn shallow(&self, ty: &Ty) -> Ty {
        let mut ty = ty;
        let mut links = 0;
        while let Ty::Var(id) = ty
            && let Some(Some(bound)) = self.bound.get(*id as usize)
            && links < 64
        {
            ty = bound;
            links += 1;
        }
        ty.clone()
    }

    /// The type with all variables replaced; `Unknown` for those that are not bound.
    pub(super) fn resolve(&self, ty: &Ty) -> Ty {
        self.resolve_at(ty, 0)
    }

    fn resolve_at(&self, ty: &Ty, depth: u32) -> Ty {
        if depth > MAX_DEPTH {
            return Ty::Unknown;
        }
        let all = |types: &[Ty]| types.iter().map(|ty| self.resolve_at(ty, depth + 1)).collect::<Vec<_>>();
        let one = |ty: &Ty| Box::new(self.resolve_at(ty, depth + 1));
        match self.shallow(ty) {
            Ty::Var(_) => Ty::Unknown,
            Ty::Adt(id, args) => Ty::Adt(id, all(&args)),
            Ty::External(path, args) => Ty::External(path, all(&args)),
            Ty::Ref(mutable, inner) => Ty::Ref(mutable, one(&inner)),
            Ty::Pointer(inner) => Ty::Pointer(one(&inner)),
            Ty::Tuple(types) => Ty::Tuple(all(&types)),
            Ty::Array(inner, length) => Ty::Array(one(&inner), length),
            Ty::Slice(inner) => Ty::Slice(one(&inner)),
            Ty::Function(params, output) => Ty::Function(all(&params), one(&output)),
            other => other,
        }
    }

    pub(super) fn unify(&mut self, left: &Ty, right: &Ty) {
        self.unify_at(left, right, 0);
    }

    fn unify_at(&mut self, left: &Ty, right: &Ty, depth: u32) {
        if depth > MAX_DEPTH {
            return;
        }
        let (left, right) = (self.shallow(left), self.shallow(right));
        match (&left, &right) {
            (Ty::Var(a), Ty::Var(b)) if a == b => {}
            (Ty::Var(id), other) | (other, Ty::Var(id))
                if !matches!(other, Ty::Unknown | Ty::Never) && !self.occurs(*id, other, 0) =>
            {
                if let (Ty::Var(other), Some(origin)) = (other, self.origins.get(id).cloned()) {
                    self.origins.entry(*other).or_insert(origin);
                }
                self.bound[*id as usize] = Some(other.clone());
            }
            (Ty::Adt(a, left), Ty::Adt(b, right)) if a == b => self.unify_all(left, right, depth),
            (Ty::External(a, left), Ty::External(b, right)) if a == b => self.unify_all(left, right, depth),
            (Ty::Tuple(left), Ty::Tuple(right)) => self.unify_all(left, right, depth),
            (Ty::Ref(_, left), Ty::Ref(_, right))
            | (Ty::Pointer(left), Ty::Pointer(right))
            | (Ty::Slice(left) | Ty::Array(left, _), Ty::Slice(right) | Ty::Array(right, _)) => {
                self.unify_at(left, right, depth + 1);
            }
            // A reference to a vector or array is a slice where one is asked for.
            (Ty::External(path, args), Ty::Slice(inner)) | (Ty::Slice(inner), Ty::External(path, args))
                if path.ends_with("::Vec") && !args.is_empty() =>
            {
                self.unify_at(&args[0], inner, depth + 1);
            }
            (Ty::Function(a, left), Ty::Function(b, right)) => {
                self.unify_all(a, b, depth);
                self.unify_at(left, right, depth + 1);
            }
            _ => {}
        }
    }

    fn unify_all(&mut self, left: &[Ty], right: &[Ty], depth: u32) {
        for (left, right) in left.iter().zip(right) {
            self.unify_at(left, right, depth + 1);
        }
    }

    fn occurs(&self, id: u32, ty: &Ty, depth: u32) -> bool {
        if depth > MAX_DEPTH {
            return true;
        }
        let any = |types: &[Ty]| types.iter().any(|ty| self.occurs(id, ty, depth + 1));
        match self.shallow(ty) {
            Ty::Var(other) => other == id,
            Ty::Adt(_, args) | Ty::External(_, args) | Ty::Tuple(args) => any(&args),
            Ty::Ref(_, inner) | Ty::Pointer(inner) | Ty::Array(inner, _) | Ty::Slice(inner) => {
                self.occurs(id, &inner, depth + 1)
            }
            Ty::Function(params, output) => any(&params) || self.occurs(id, &output, depth + 1),
            _ => false,
        }
    }
}
