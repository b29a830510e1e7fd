//! Types with parameters against types that stand in their place.

use super::{FunctionId, Index, Owner, Ty};
use crate::syntax::tree::TypeRef;

impl Ty {
    /// What the parameters in this type stand for where it is another one.
    #[must_use]
    pub fn bindings(&self, ty: &Self) -> Vec<(String, Self)> {
        let mut found = Vec::new();
        bind(self, ty, &mut found);
        found
    }

    /// Whether it is the other type for some choice of its parameters; what is not known may be any type.
    #[must_use]
    pub fn admits(&self, ty: &Self) -> bool {
        let all = |left: &[Self], right: &[Self]| {
            left.len() == right.len() && left.iter().zip(right).all(|(left, right)| left.admits(right))
        };
        match (self, ty) {
            (Self::Param(_) | Self::Opaque(_) | Self::Unknown | Self::Var(_), _) => true,
            (_, Self::Param(_) | Self::Opaque(_) | Self::Unknown | Self::Var(_)) => true,
            (Self::Adt(left, of), Self::Adt(right, to)) => left == right && all(of, to),
            (Self::External(left, of), Self::External(right, to)) => left == right && all(of, to),
            (Self::Tuple(of), Self::Tuple(to)) => all(of, to),
            (Self::Ref(_, left), Self::Ref(_, right))
            | (Self::Pointer(left), Self::Pointer(right))
            | (Self::Array(left, _), Self::Array(right, _))
            | (Self::Slice(left), Self::Slice(right)) => left.admits(right),
            (left, right) => std::mem::discriminant(left) == std::mem::discriminant(right),
        }
    }

    /// Whether both may stand for one type. Of names outside of the analysed code nobody knows whether they are other names of a
    /// type, or constants; only two that were found, and are called differently, are two.
    #[must_use]
    pub fn may_be(&self, ty: &Self) -> bool {
        let all = |left: &[Self], right: &[Self]| left.iter().zip(right).all(|(left, right)| left.may_be(right));
        // What is coerced, as references and closures are, may be taken for another type.
        let is_known = |ty: &Self| {
            matches!(ty, Self::Adt(..) | Self::Tuple(_) | Self::Int | Self::Float | Self::Bool | Self::Str | Self::Char)
        };
        match (self, ty) {
            (Self::Adt(left, of), Self::Adt(right, to)) => left == right && all(of, to),
            (Self::External(left, of), Self::External(right, to)) => {
                let is_found = |path: &str| !path.starts_with("?::");
                let is_alike = left.rsplit("::").next() == right.rsplit("::").next();
                if is_alike { all(of, to) } else { !is_found(left) || !is_found(right) }
            }
            (Self::Tuple(of), Self::Tuple(to)) => of.len() == to.len() && all(of, to),
            (Self::Ref(_, left), Self::Ref(_, right))
            | (Self::Pointer(left), Self::Pointer(right))
            | (Self::Array(left, _), Self::Array(right, _))
            | (Self::Slice(left), Self::Slice(right)) => left.may_be(right),
            (left, right) => {
                !is_known(left) || !is_known(right) || std::mem::discriminant(left) == std::mem::discriminant(right)
            }
        }
    }

    /// Whether a parameter, or what the inference has left open, is a part of it.
    #[must_use]
    pub fn is_open(&self) -> bool {
        match self {
            Self::Param(_) | Self::Var(_) => true,
            Self::Adt(_, parts) | Self::External(_, parts) | Self::Tuple(parts) => parts.iter().any(Self::is_open),
            Self::Ref(_, inner) | Self::Pointer(inner) | Self::Array(inner, _) | Self::Slice(inner) => inner.is_open(),
            Self::Function(params, output) => output.is_open() || params.iter().any(Self::is_open),
            _ => false,
        }
    }
}

impl Index {
    /// Whether a function has parameters that types can stand in the place of, its own or those of what it belongs to: `impl Trait`
    /// and `dyn Trait` among them.
    #[must_use]
    pub fn is_generic(&self, id: FunctionId) -> bool {
        let def = self.function(id);
        let of_owner = match def.owner {
            Owner::Impl(of) => !self.impl_def(of).generics.params.is_empty(),
            Owner::Trait(_) => true,
            Owner::Module => false,
        };
        of_owner || !def.function.generics.params.is_empty() || def.function.params.iter().any(hides_type)
    }
}

fn hides_type(ty: &TypeRef) -> bool {
    match ty {
        TypeRef::Reference { inner, .. } => hides_type(inner),
        TypeRef::ImplTrait(_) | TypeRef::DynTrait(_) => true,
        _ => false,
    }
}

fn bind(pattern: &Ty, ty: &Ty, map: &mut Vec<(String, Ty)>) {
    match (pattern, ty) {
        (Ty::Param(param), ty) if *ty != Ty::Unknown => map.push((param.name.clone(), ty.clone())),
        (Ty::Adt(_, left), Ty::Adt(_, right))
        | (Ty::External(_, left), Ty::External(_, right))
        | (Ty::Tuple(left), Ty::Tuple(right)) => {
            for (left, right) in left.iter().zip(right) {
                bind(left, right, map);
            }
        }
        (Ty::Ref(_, left), Ty::Ref(_, right))
        | (Ty::Array(left, _), Ty::Array(right, _))
        | (Ty::Slice(left), Ty::Slice(right)) => bind(left, right, map),
        _ => {}
    }
}
