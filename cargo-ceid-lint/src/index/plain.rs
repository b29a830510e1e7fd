//! Types whose values are nothing but data.

use std::collections::BTreeSet;

use super::{Index, Owner, Shape, Ty, TypeId};
use crate::syntax::tree::Variant;

impl Index {
    /// Whether values of a type are the same as long as nobody has them to himself: numbers, texts, and what consists of such.
    #[must_use]
    pub fn is_plain(&self, ty: &Ty) -> bool {
        self.consists_of_plain(ty, &mut BTreeSet::new())
    }

    fn consists_of_plain(&self, ty: &Ty, seen: &mut BTreeSet<TypeId>) -> bool {
        match ty {
            Ty::Int | Ty::Float | Ty::Bool | Ty::Str | Ty::Char => true,
            Ty::Ref(false, inner) | Ty::Array(inner, _) | Ty::Slice(inner) => self.consists_of_plain(inner, seen),
            Ty::Tuple(parts) => parts.iter().all(|part| self.consists_of_plain(part, seen)),
            Ty::External(path, args) => {
                let name = path.strip_prefix("std::").and_then(|path| path.rsplit("::").next());
                matches!(name, Some("Box" | "Vec" | "String" | "Option" | "Duration" | "Rc" | "Arc" | "BTreeMap"))
                    && args.iter().all(|arg| self.consists_of_plain(arg, seen))
            }
            Ty::Adt(id, args) => {
                args.iter().all(|arg| self.consists_of_plain(arg, seen))
                    && (!seen.insert(*id)
                        || self.field_types(ty).iter().all(|field| self.consists_of_plain(field, seen)))
            }
            _ => false,
        }
    }

    /// Whether a value of a type may hold a reference by which something is written.
    #[must_use]
    pub fn holds_writer(&self, ty: &Ty) -> bool {
        self.may_write(ty, &mut BTreeSet::new())
    }

    fn may_write(&self, ty: &Ty, seen: &mut BTreeSet<TypeId>) -> bool {
        match ty {
            Ty::Ref(is_mutable, inner) => *is_mutable || self.may_write(inner, seen),
            Ty::Array(inner, _) | Ty::Slice(inner) => self.may_write(inner, seen),
            Ty::Tuple(parts) | Ty::External(_, parts) => parts.iter().any(|part| self.may_write(part, seen)),
            Ty::Adt(id, args) => {
                args.iter().any(|arg| self.may_write(arg, seen))
                    || seen.insert(*id) && self.field_types(ty).iter().any(|field| self.may_write(field, seen))
            }
            Ty::Opaque(_) | Ty::Closure(_) => true,
            _ => false,
        }
    }

    /// The names of the variants of each enum of the analysed code.
    pub fn variants_of_enums(&self) -> impl Iterator<Item = Vec<&str>> {
        self.types.iter().filter_map(|def| match &def.shape {
            Shape::Enum(variants) => Some(variants.iter().map(|variant| variant.name.as_str()).collect()),
            Shape::Struct(_) => None,
        })
    }

    /// The enums of that name.
    pub fn enums_named<'a>(&'a self, name: &'a str) -> impl Iterator<Item = TypeId> + 'a {
        let all = (0u32..).map(TypeId).zip(&self.types);
        all.filter(move |(_, def)| def.name == name && matches!(def.shape, Shape::Enum(_))).map(|(id, _)| id)
    }

    /// The variants of an enum.
    #[must_use]
    pub fn variants_of(&self, id: TypeId) -> Option<&[Variant]> {
        match &self.type_def(id).shape {
            Shape::Enum(variants) => Some(variants),
            Shape::Struct(_) => None,
        }
    }

    /// The number of a variant of an enum of the analysed code.
    #[must_use]
    pub fn variant_named(&self, ty: &Ty, name: &str) -> Option<usize> {
        let Ty::Adt(id, _) = ty else { return None };
        match &self.type_def(*id).shape {
            Shape::Enum(variants) => variants.iter().position(|variant| variant.name == name),
            Shape::Struct(_) => None,
        }
    }

    /// The types of the fields of a type of the analysed code, of all its variants.
    #[must_use]
    pub fn field_types(&self, ty: &Ty) -> Vec<Ty> {
        let Ty::Adt(id, _) = ty else { return Vec::new() };
        let def = self.type_def(*id);
        let scope = self.scope(def.module, Owner::Module, Some(&def.generics));
        let fields = match &def.shape {
            Shape::Struct(fields) => fields.fields.iter().collect::<Vec<_>>(),
            Shape::Enum(variants) => variants.iter().flat_map(|variant| &variant.fields.fields).collect(),
        };
        fields.iter().map(|field| self.lower(&field.ty, &scope)).collect()
    }

    /// The same for a type whose parameters stand for something.
    #[must_use]
    pub fn fields_of(&self, ty: &Ty) -> Vec<Ty> {
        let Ty::Adt(id, args) = ty else { return Vec::new() };
        let args = super::ty::named_args(&self.type_def(*id).generics, args);
        self.field_types(ty).iter().map(|field| field.substitute(&args)).collect()
    }
}
