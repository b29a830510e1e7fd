//! Methods that traits of the analysed code give to what is no type of its own: numbers, truth values, characters, texts, references.

use super::{Index, MethodOwner, TraitName, Ty};

/// Whether a type is one of the language's own values.
pub(super) fn is_primitive(ty: &Ty) -> bool {
    matches!(ty, Ty::Bool | Ty::Int | Ty::Float | Ty::Char | Ty::Str)
}

impl Index {
    /// Notes the methods of an impl for such a type.
    pub(super) fn note_extension(&mut self, id: super::ImplId, implements: Option<&TraitName>) {
        let of_trait = match implements {
            Some(TraitName::Local(of)) => self.trait_def(*of).methods.keys().cloned().collect(),
            _ => Vec::new(),
        };
        let own: Vec<String> = self.impl_def(id).methods.keys().cloned().chain(of_trait).collect();
        for name in own {
            let known = self.extensions.entry(name).or_default();
            if known.last() != Some(&id) {
                known.push(id);
            }
        }
    }

    /// The methods of that name that impls give to a primitive type, or to a reference as such.
    #[must_use]
    pub fn extension_methods(&self, ty: &Ty, name: &str) -> Vec<MethodOwner> {
        let is_for = |own: &Ty| match (own, ty) {
            (Ty::Ref(mutable, own), Ty::Ref(other, inner)) => {
                mutable == other && (own.admits(inner) && self.keeps_bounds(own, inner))
            }
            _ => own == ty,
        };
        let own =
            self.extensions.get(name).into_iter().flatten().copied().filter(|id| is_for(&self.impl_def(*id).self_ty));
        let blankets = self.blankets.iter().copied().filter(|id| {
            is_primitive(ty) && self.keeps_bounds(&self.impl_def(*id).self_ty, ty) && self.gives_method(*id, name)
        });
        let mut found = Vec::new();
        for id in own.chain(blankets) {
            let def = self.impl_def(id);
            let Some(implements) = &def.implements else { continue };
            let declared = match implements {
                TraitName::Local(of) => self.trait_def(*of).methods.get(name).copied(),
                TraitName::External(_) => None,
            };
            if let Some(function) = def.methods.get(name).copied().or(declared) {
                found.push(MethodOwner::Implemented(implements.clone(), function));
            }
        }
        // `f32` and `f64` are one type here: any of their impls may be meant.
        if let [MethodOwner::Implemented(TraitName::Local(of), _), _, ..] = found.as_slice() {
            let declared = self.trait_def(*of).methods.get(name).copied();
            return vec![MethodOwner::Declared(TraitName::Local(*of), declared)];
        }
        found
    }

    fn gives_method(&self, id: super::ImplId, name: &str) -> bool {
        let def = self.impl_def(id);
        let is_declared =
            matches!(&def.implements, Some(TraitName::Local(of)) if self.trait_def(*of).methods.contains_key(name));
        is_declared || def.methods.contains_key(name)
    }

    /// Whether a type may have what the parameter of an impl is bound by. Of primitive types, traits of others may all hold.
    fn keeps_bounds(&self, own: &Ty, ty: &Ty) -> bool {
        let Ty::Param(param) = own else { return true };
        param.bounds.iter().all(|bound| match &bound.name {
            TraitName::External(_) => true,
            TraitName::Local(of) if is_primitive(ty) => {
                let impls = self.impls_of_trait.get(of).into_iter().flatten();
                impls.map(|id| &self.impl_def(*id).self_ty).any(|own| own == ty)
            }
            TraitName::Local(_) => self.implements(ty, &bound.name) || matches!(ty, Ty::Unknown | Ty::Var(_)),
        })
    }
}
