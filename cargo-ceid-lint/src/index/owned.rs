//! What owning or borrowing a value of a type may lead to: destructors of the analysed code, what can be called, and what several own.

use rustc_hash::FxHashSet;

use super::{Index, Ty, TypeId};

/// The types whose values lead to something, at any depth, whatever their parameters stand for.
#[derive(Debug, Default)]
pub(super) struct Leading {
    destructors: FxHashSet<TypeId>,
    callables: FxHashSet<TypeId>,
    handles: FxHashSet<TypeId>,
}

impl Leading {
    /// Goes from what has it to what has that in a field.
    pub(super) fn find(index: &Index, fields: &[(TypeId, Vec<Ty>)]) -> Self {
        let of_drop = index
            .impls
            .iter()
            .filter(|def| def.implements.as_ref().is_some_and(|name| index.trait_text(name) == "Drop"));
        let destructors = of_drop.filter_map(|def| if let Ty::Adt(id, _) = &def.self_ty { Some(*id) } else { None });
        let with_part = |is_such: &dyn Fn(&Ty) -> bool| {
            let has_such = |all: &[Ty]| all.iter().any(|ty| ty.has_part(&mut |part| is_such(part)));
            holders(fields.iter().filter(|(_, all)| has_such(all)).map(|(id, _)| *id).collect(), fields)
        };
        Self {
            destructors: holders(destructors.collect(), fields),
            callables: with_part(&Ty::is_callable),
            handles: with_part(&|ty| index.is_shared_handle(ty)),
        }
    }
}

/// The types that have one of these in a field, at any depth, and these themselves.
fn holders(mut found: FxHashSet<TypeId>, fields: &[(TypeId, Vec<Ty>)]) -> FxHashSet<TypeId> {
    if found.is_empty() {
        return found;
    }
    let mut held_by: Vec<(TypeId, TypeId)> = Vec::new();
    for (holder, all) in fields {
        for ty in all {
            ty.has_part(&mut |part| {
                if let Ty::Adt(id, _) = part {
                    held_by.push((*id, *holder));
                }
                false
            });
        }
    }
    held_by.sort_unstable();
    let mut open: Vec<TypeId> = found.iter().copied().collect();
    while let Some(id) = open.pop() {
        let first = held_by.partition_point(|(held, _)| *held < id);
        let of_same = held_by[first..].iter().take_while(|(held, _)| *held == id);
        open.extend(of_same.map(|(_, holder)| *holder).filter(|holder| found.insert(*holder)));
    }
    found
}

impl Index {
    /// Whether a type has fields that are filters or hold some.
    #[must_use]
    pub fn has_filters_inside(&self, ty: &Ty) -> bool {
        let ty = ty.peel();
        let Ty::Adt(id, _) = ty else { return false };
        let holds = |variant: Option<usize>, fields: &super::Fields| {
            let mut types = fields.fields.iter().filter_map(|field| self.field_ty(ty, variant, &field.name));
            types.any(|ty| self.holds_filter(&ty))
        };
        match &self.type_def(*id).shape {
            super::Shape::Struct(fields) => holds(None, fields),
            super::Shape::Enum(variants) => {
                variants.iter().enumerate().any(|(number, variant)| holds(Some(number), &variant.fields))
            }
        }
    }

    /// Whether a destructor of the analysed code may run where a value of the type is dropped.
    #[must_use]
    pub fn leads_to_destructor(&self, ty: &Ty) -> bool {
        ty.has_part(&mut |part| matches!(part, Ty::Adt(id, _) if self.leading.destructors.contains(id)))
    }

    /// Whether a value of the type may lead to something that is called.
    #[must_use]
    pub fn leads_to_callable(&self, ty: &Ty) -> bool {
        ty.has_part(&mut |part| {
            part.is_callable() || matches!(part, Ty::Adt(id, _) if self.leading.callables.contains(id))
        })
    }

    /// Whether clones of a value lead to the same thing: a pointer that several own, or a filter that is a handle to its state.
    fn is_shared_handle(&self, ty: &Ty) -> bool {
        ty.is_shared_pointer() || self.shares_state(ty)
    }

    /// Whether a value of the type may lead to a filter by a handle whose clones lead there as well.
    #[must_use]
    pub fn may_share_filter(&self, ty: &Ty) -> bool {
        self.holds_filter(ty)
            && ty.has_part(&mut |part| {
                self.is_shared_handle(part) || matches!(part, Ty::Adt(id, _) if self.leading.handles.contains(id))
            })
    }
}
