//! Which impls may be for a type, and which traits a type may have: only what all code that is there rules out is left out.

use super::{ImplId, Index, Owner, TraitName, TraitRef, Ty, TypeId};
use crate::syntax::tree::{GenericArg, OpaqueMacro, TypeRef};

/// How deep the bounds of impls are followed.
const MAX_DEPTH: u32 = 4;

impl Index {
    /// Whether an impl may be one for the type: what stands where its parameters are may have the traits that these ask for.
    pub(super) fn may_cover(&self, id: ImplId, ty: &Ty) -> bool {
        let own = &self.impl_def(id).self_ty;
        own.may_be(ty) && self.may_stand_for(id, own, ty, 0)
    }

    /// Whether a part of the type of an impl may be another type, which it is but for parameters.
    fn may_stand_for(&self, id: ImplId, own: &Ty, ty: &Ty, depth: u32) -> bool {
        let go = |left: &Ty, right: &Ty| self.may_stand_for(id, left, right, depth);
        let all = |left: &[Ty], right: &[Ty]| left.iter().zip(right).all(|(left, right)| go(left, right));
        match (own, ty) {
            (Ty::Param(param), _) => param.bounds.iter().all(|bound| self.may_implement_at(ty, &bound.name, depth + 1)),
            // `impl Effect for Box<dyn Effect>` says nothing of a `Box<Delay>`.
            (Ty::Opaque(_), Ty::Adt(..)) => !names_object(&self.impl_def(id).self_ref),
            (Ty::Adt(_, left), Ty::Adt(_, right))
            | (Ty::External(_, left), Ty::External(_, right))
            | (Ty::Tuple(left), Ty::Tuple(right)) => all(left, right),
            (Ty::Ref(_, left), Ty::Ref(_, right))
            | (Ty::Array(left, _), Ty::Array(right, _))
            | (Ty::Slice(left), Ty::Slice(right)) => go(left, right),
            _ => true,
        }
    }

    /// Whether an impl may be meant where something has a bound: it is of that trait with these arguments, or its type may have the trait.
    #[must_use]
    pub fn may_have(&self, id: ImplId, bound: &TraitRef) -> bool {
        let def = self.impl_def(id);
        match &def.trait_path {
            Some(path) if def.implements.as_ref() == Some(&bound.name) => {
                let scope = self.scope(def.module, Owner::Module, Some(&def.generics));
                let own = self.lower_bounds(std::slice::from_ref(path), &scope, 0);
                own.iter().all(|own| own.args.iter().zip(&bound.args).all(|(left, right)| left.may_be(right)))
            }
            _ => self.may_implement_at(&def.self_ty, &bound.name, 0),
        }
    }

    fn may_implement_at(&self, ty: &Ty, name: &TraitName, depth: u32) -> bool {
        let TraitName::Local(of) = name else { return true };
        let own = match ty {
            _ if depth > MAX_DEPTH => return true,
            Ty::Adt(id, _) => &self.type_def(*id).name,
            Ty::Int | Ty::Float | Ty::Bool | Ty::Char | Ty::Tuple(_) | Ty::External(..) => "",
            _ => return true,
        };
        let def = self.trait_def(*of);
        let derives = |ty: &Ty| match ty {
            Ty::Adt(id, _) => self.type_def(*id).attributes.iter().any(|attribute| attribute.derives(&def.name)),
            _ => false,
        };
        let is_by_impl = |id: &ImplId| {
            let impl_ty = &self.impl_def(*id).self_ty;
            impl_ty.may_be(ty) && self.may_stand_for(*id, impl_ty, ty, depth + 1)
        };
        let impls = match ty {
            // The macro of a filter set writes the impl.
            Ty::Adt(id, _) if def.name == "SampledFilter" && self.is_filter_set(*id) => return true,
            // Most types have their traits by an impl of their own.
            Ty::Adt(id, _) if self.has_trait(*id, name) => return true,
            Ty::Adt(..) => self.blankets_of(name),
            _ => self.impls_of_trait.get(of).map_or(&[][..], Vec::as_slice),
        };
        impls.iter().any(is_by_impl) || derives(ty) || self.is_made_unread([own, &def.name])
    }

    /// Whether a struct was made by ceid-core's `filters!`.
    #[must_use]
    pub fn is_filter_set(&self, id: TypeId) -> bool {
        self.type_def(id).attributes.iter().any(|own| own.path == "ceid_core::filters")
    }

    /// Whether an item that could not be read may define something of what has one of these names.
    pub(super) fn is_made_unread(&self, names: [&str; 2]) -> bool {
        self.opaque_items.iter().any(|(_, call)| may_define(call, names))
    }
}

/// Whether a trait object is a part of a type.
fn names_object(ty: &TypeRef) -> bool {
    match ty {
        TypeRef::DynTrait(_) => true,
        TypeRef::Reference { inner, .. }
        | TypeRef::Pointer(inner)
        | TypeRef::Array(inner, _)
        | TypeRef::Slice(inner) => names_object(inner),
        TypeRef::Tuple(parts) => parts.iter().any(names_object),
        TypeRef::Path(path) => path.segments.iter().flat_map(|segment| &segment.args).any(|arg| match arg {
            GenericArg::Type(ty) | GenericArg::Assoc(_, ty) => names_object(ty),
            GenericArg::Const(_) | GenericArg::Constraint(..) => false,
        }),
        _ => false,
    }
}

/// Whether a macro where an item stands may define something of what has one of these names: it names that, or nothing that
/// could be looked for.
pub(super) fn may_define(call: &OpaqueMacro, names: [&str; 2]) -> bool {
    let called = call.path.rsplit("::").next().unwrap_or_default();
    call.mentions.is_empty()
        || called.starts_with("include")
        || call.mentions.iter().any(|own| names.contains(&own.as_str()))
}
