//! Types, parameters in angle brackets. Never resolves names.

use syn::spanned::Spanned as _;

use super::path::const_text;
use super::{Lowerer, name};
use crate::source::Span;
use crate::syntax::tree::{GenericParam, Generics, TypeRef};

/// Types nested deeper than this are not read: they are dropped and compared by recursion everywhere above this floor.
const MAX_TYPE_DEPTH: usize = 200;

impl Lowerer<'_, '_> {
    pub(super) fn ty(&self, ty: &syn::Type) -> TypeRef {
        // The depth is kept in a cell, for types hold paths and paths hold types.
        let depth = self.type_depth.get();
        if depth >= MAX_TYPE_DEPTH {
            return TypeRef::Unknown;
        }
        self.type_depth.set(depth + 1);
        let lowered = self.ty_inner(ty);
        self.type_depth.set(depth);
        lowered
    }

    fn ty_inner(&self, ty: &syn::Type) -> TypeRef {
        match ty {
            syn::Type::Paren(paren) => self.ty(&paren.elem),
            syn::Type::Group(group) => self.ty(&group.elem),
            syn::Type::Path(path) => TypeRef::Path(self.path(path.qself.as_ref(), &path.path)),
            syn::Type::Reference(reference) => TypeRef::Reference {
                mutable: reference.mutability.is_some(),
                inner: Box::new(self.ty(&reference.elem)),
            },
            syn::Type::Ptr(pointer) => TypeRef::Pointer(Box::new(self.ty(&pointer.elem))),
            syn::Type::Tuple(tuple) => TypeRef::Tuple(tuple.elems.iter().map(|elem| self.ty(elem)).collect()),
            syn::Type::Array(array) => TypeRef::Array(Box::new(self.ty(&array.elem)), const_text(&array.len)),
            syn::Type::Slice(slice) => TypeRef::Slice(Box::new(self.ty(&slice.elem))),
            syn::Type::ImplTrait(bounds) => TypeRef::ImplTrait(self.bounds(&bounds.bounds)),
            syn::Type::TraitObject(bounds) => TypeRef::DynTrait(self.bounds(&bounds.bounds)),
            syn::Type::FnPtr(pointer) => TypeRef::FnPointer(
                pointer.inputs.iter().map(|input| self.ty(&input.ty)).collect(),
                Box::new(self.return_type(&pointer.output)),
            ),
            syn::Type::Never(_) => TypeRef::Never,
            syn::Type::Infer(_) => TypeRef::Infer,
            _ => TypeRef::Unknown,
        }
    }

    pub(super) fn return_type(&self, output: &syn::ReturnType) -> TypeRef {
        match output {
            syn::ReturnType::Default => TypeRef::unit(),
            syn::ReturnType::Type(_, ty) => self.ty(ty),
        }
    }

    pub(super) fn type_span(&self, ty: &syn::Type) -> Span {
        self.span(ty.span())
    }

    pub(in crate::syntax) fn generics(&self, generics: &syn::Generics) -> Generics {
        let params = generics.params.iter().filter_map(|param| match param {
            syn::GenericParam::Lifetime(_) => None,
            syn::GenericParam::Type(param) => {
                self.cfg_key(&param.attrs)?;
                Some(GenericParam {
                    name: name(&param.ident),
                    is_const: false,
                    bounds: self.bounds(&param.bounds),
                    default: param.default.as_ref().map(|(_, ty)| self.ty(ty)),
                })
            }
            syn::GenericParam::Const(param) => {
                self.cfg_key(&param.attrs)?;
                Some(GenericParam { name: name(&param.ident), is_const: true, bounds: Vec::new(), default: None })
            }
        });
        let predicates = generics.where_clause.iter().flat_map(|clause| &clause.predicates);
        Generics {
            params: params.collect(),
            has_lifetimes: generics.lifetimes().next().is_some(),
            predicates: predicates
                .filter_map(|predicate| match predicate {
                    syn::WherePredicate::Type(predicate) => {
                        Some((self.ty(&predicate.bounded_ty), self.bounds(&predicate.bounds)))
                    }
                    _ => None,
                })
                .collect(),
        }
    }
}
