//! Impls and methods of a type. Follows no references: that is the inference's work.

use std::sync::Arc;

use rustc_hash::FxHashSet;

use super::extensions::is_primitive;
use super::{
    FilterSpec, FunctionId, ImplDef, ImplId, Index, Owner, Subject, TraitDef, TraitId, TraitName, TraitRef, Ty, TypeId,
    ValueId,
};
use crate::syntax::tree::{Attribute, TypeRef};

/// Where a method was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MethodOwner {
    /// In an impl without a trait.
    Inherent(FunctionId),
    /// In an impl of a trait, or as the trait's default for the type.
    Implemented(TraitName, FunctionId),
    /// In the declaration of a trait that bounds a parameter or object: every impl may be meant.
    Declared(TraitName, Option<FunctionId>),
}

impl MethodOwner {
    /// The function or signature.
    #[must_use]
    pub fn function(&self) -> Option<FunctionId> {
        match self {
            Self::Inherent(id) | Self::Implemented(_, id) => Some(*id),
            Self::Declared(_, id) => *id,
        }
    }

    /// The trait it belongs to.
    #[must_use]
    pub fn of_trait(&self) -> Option<&TraitName> {
        match self {
            Self::Inherent(_) => None,
            Self::Implemented(name, _) | Self::Declared(name, _) => Some(name),
        }
    }
}

/// Traits of numbers that floats have, and that ask for no whole order.
const FLOATING: &[&str] =
    &["Float", "FloatCore", "Real", "RealField", "Num", "NumCast", "NumOps", "NumAssign", "Zero", "One", "Signed"];

impl Index {
    /// Resolves the types and traits of all impls.
    pub(super) fn link(&mut self) {
        for number in 0..self.impls.len() {
            let id = ImplId(u32::try_from(number).expect("fewer than 2^32 impls"));
            let def = self.impl_def(id);
            let scope = self.scope(def.module, Owner::Module, Some(&def.generics));
            let self_ty = self.lower(&def.self_ref, &scope);
            let implements = def.trait_path.as_ref().and_then(|path| self.trait_name(def.module, path));
            match &self_ty {
                Ty::Adt(ty, _) => {
                    self.impls_of_type.entry(*ty).or_default().push(id);
                    self.traits_of_type.entry(*ty).or_default().extend(implements.clone());
                }
                Ty::External(path, _) => {
                    self.impls_of_external.entry(path.clone()).or_default().push(id);
                    self.traits_of_external.entry(path.clone()).or_default().extend(implements.clone());
                }
                Ty::Param(_) => {
                    self.blankets.push(id);
                    if let Some(of) = &implements {
                        self.blankets_of_trait.entry(of.clone()).or_default().push(id);
                    }
                }
                Ty::Array(..) | Ty::Slice(_) | Ty::Tuple(_) | Ty::Opaque(_) => self.impls_of_shapes.push(id),
                Ty::Ref(mutable, inner) => {
                    if let Ty::Adt(ty, _) = **inner {
                        self.impls_of_reference.entry((*mutable, ty)).or_default().push(id);
                    }
                    self.note_extension(id, implements.as_ref());
                }
                // Libraries of mathematics have thousands of these.
                primitive if is_primitive(primitive) => self.note_extension(id, implements.as_ref()),
                _ => {}
            }
            match &implements {
                Some(TraitName::Local(of)) => self.impls_of_trait.entry(*of).or_default().push(id),
                Some(TraitName::External(of)) => self.impls_of_foreign.entry(of.clone()).or_default().push(id),
                None => {}
            }
            let def = &mut self.impls[number];
            def.self_ty = self_ty;
            def.implements = implements;
        }
        self.implied = self.traits.iter().map(|def| self.implied_by(def)).collect();
        let derived = self.types.iter().flat_map(|def| &def.attributes).flat_map(Attribute::derived);
        self.derived = derived.map(str::to_owned).collect();
    }

    /// The traits that a trait asks for, those that they ask for included.
    fn implied_by(&self, def: &TraitDef) -> FxHashSet<TraitName> {
        let mut implied = FxHashSet::default();
        let mut open = vec![def];
        while let Some(def) = open.pop() {
            for bound in &def.supertraits {
                let Some(name) = self.trait_name(def.module, bound) else { continue };
                if implied.insert(name.clone())
                    && let TraitName::Local(id) = name
                {
                    open.push(self.trait_def(id));
                }
            }
        }
        implied
    }

    /// The impls whose type this is, blanket impls included whose bounds hold.
    #[must_use]
    pub fn impls_of(&self, ty: &Ty) -> Vec<ImplId> {
        let several = if matches!(ty, Ty::Adt(..) | Ty::External(..)) { &self.blankets } else { &self.impls_of_shapes };
        let mut impls = match ty {
            Ty::Adt(id, _) => self.impls_of_type.get(id).cloned().unwrap_or_default(),
            Ty::External(path, _) => self.impls_of_external.get(path).cloned().unwrap_or_default(),
            Ty::Ref(mutable, inner) => match **inner {
                Ty::Adt(id, _) => self.impls_of_reference.get(&(*mutable, id)).cloned().unwrap_or_default(),
                _ => Vec::new(),
            },
            _ => Vec::new(),
        };
        impls.extend(several.iter().filter(|id| self.blanket_holds(**id, ty)));
        impls
    }

    /// Whether an impl for a parameter, reference, array or tuple covers the type.
    fn blanket_holds(&self, id: ImplId, ty: &Ty) -> bool {
        let def = self.impl_def(id);
        match (&def.self_ty, ty) {
            (Ty::Param(param), Ty::Adt(..) | Ty::External(..)) => {
                // An impl that asks for itself would never end.
                param
                    .bounds
                    .iter()
                    .all(|bound| Some(&bound.name) != def.implements.as_ref() && self.implements(ty, &bound.name))
            }
            (own @ (Ty::Array(..) | Ty::Slice(_) | Ty::Tuple(_)), ty) => own.admits(ty),
            (Ty::Opaque(left), Ty::Opaque(right)) => left == right,
            _ => false,
        }
    }

    /// Whether the type implements a trait of a crate that is not read by methods that may change a value: other methods, which that
    /// trait provides, may run these.
    #[must_use]
    pub fn implements_what_is_not_read(&self, ty: &Ty) -> bool {
        let changes = |method: &FunctionId| {
            self.function(*method).function.receiver == Some(crate::syntax::tree::Receiver::Exclusive)
        };
        self.impls_of(ty).into_iter().map(|id| self.impl_def(id)).any(|def| match &def.implements {
            Some(TraitName::External(path)) => {
                let provides = !(path.ends_with("Assign") || path.ends_with("Mut") || path.ends_with("::Drop"));
                provides && def.methods.values().any(changes)
            }
            _ => false,
        })
    }

    /// Whether `[]` of a type that is not known may run analysed code.
    #[must_use]
    pub fn says_what_indexing_means(&self) -> bool {
        self.impls.iter().any(|def| match &def.implements {
            Some(TraitName::External(path)) => path.ends_with("::IndexMut"),
            _ => false,
        })
    }

    /// Whether the type implements the trait, as far as the analysed code tells.
    #[must_use]
    pub fn implements(&self, ty: &Ty, name: &TraitName) -> bool {
        match ty {
            Ty::Param(param) => self.bounds_imply(&param.bounds, name) || self.blanket_gives(&param.bounds, name),
            Ty::Opaque(bounds) => self.bounds_imply(bounds, name) || self.blanket_gives(bounds, name),
            Ty::Adt(..) | Ty::External(..) => {
                let own = match ty {
                    Ty::Adt(id, _) => self.traits_of_type.get(id),
                    Ty::External(path, _) => self.traits_of_external.get(path),
                    _ => None,
                };
                own.is_some_and(|traits| traits.contains(name))
                    || self.blankets_of(name).iter().any(|id| self.blanket_holds(*id, ty))
                    || matches!(name, TraitName::External(path) if is_auto(path) || self.derives(ty, path))
            }
            _ => false,
        }
    }

    /// Whether a type derives a trait of the standard library.
    pub(super) fn derives(&self, ty: &Ty, path: &str) -> bool {
        let (Ty::Adt(id, _), Some(path)) = (ty, path.strip_prefix("std::")) else { return false };
        let name = path.rsplit("::").next().unwrap_or_default();
        self.type_def(*id).attributes.iter().any(|attribute| attribute.derives(name))
    }

    /// Whether an impl for a type parameter has a method of that name: which types it covers may not be seen.
    #[must_use]
    pub fn has_blanket_method(&self, name: &str) -> bool {
        self.blankets.iter().map(|id| self.impl_def(*id)).any(|def| {
            let of_trait = match &def.implements {
                Some(TraitName::Local(of)) => self.trait_def(*of).methods.contains_key(name),
                _ => false,
            };
            of_trait || def.methods.contains_key(name)
        })
    }

    /// Whether an impl for the type itself gives it the trait.
    pub(super) fn has_trait(&self, id: TypeId, name: &TraitName) -> bool {
        self.traits_of_type.get(&id).is_some_and(|traits| traits.contains(name))
    }

    fn bounds_imply(&self, bounds: &[TraitRef], name: &TraitName) -> bool {
        bounds.iter().any(|bound| {
            bound.name == *name
                || match bound.name {
                    TraitName::Local(id) => self.implied[id.0 as usize].contains(name),
                    TraitName::External(_) => false,
                }
        })
    }

    /// Whether two values of a type that is known by its bounds only may stand to each other in no order: what is only `PartialOrd` may
    /// be a float.
    #[must_use]
    pub fn may_lack_order(&self, bounds: &[TraitRef]) -> bool {
        let names = bounds.iter().flat_map(|bound| {
            let implied = match bound.name {
                TraitName::Local(id) => Some(&self.implied[id.0 as usize]),
                TraitName::External(_) => None,
            };
            implied.into_iter().flatten().chain([&bound.name])
        });
        let paths: Vec<&str> = names
            .filter_map(|name| match name {
                TraitName::External(path) => Some(path.as_str()),
                TraitName::Local(_) => None,
            })
            .collect();
        let is = |path: &str, names: &[&str]| names.contains(&path.rsplit("::").next().unwrap_or(path));
        // Whether another trait that is not read asks for a whole order is not seen.
        let may_order = |path: &&str| !path.starts_with("std::") && !is(path, FLOATING);
        paths.iter().any(|path| is(path, &["PartialOrd"]) || is(path, FLOATING))
            && !paths.iter().any(|path| is(path, &["Ord"]) || may_order(path))
    }

    /// The impls of the trait for a type parameter.
    pub(super) fn blankets_of(&self, name: &TraitName) -> &[ImplId] {
        self.blankets_of_trait.get(name).map_or(&[], Vec::as_slice)
    }

    /// Whether a blanket impl gives the trait to everything that has these bounds.
    fn blanket_gives(&self, bounds: &[TraitRef], name: &TraitName) -> bool {
        self.blankets_of(name).iter().any(|id| {
            let Ty::Param(param) = &self.impl_def(*id).self_ty else { return false };
            !param.bounds.is_empty() && param.bounds.iter().all(|asked| self.bounds_imply(bounds, &asked.name))
        })
    }

    /// What the parameters of an impl stand for when its type is this one.
    #[must_use]
    pub fn impl_args(&self, id: ImplId, ty: &Ty) -> Vec<(String, Ty)> {
        self.impl_def(id).self_ty.bindings(ty)
    }

    /// What a trait makes of the types that implement it, where a method of it is a law or a half of one.
    #[must_use]
    pub fn law_of_trait(&self, name: &TraitName, method: &str) -> Option<&FilterSpec> {
        let is_it = |spec: &&FilterSpec| matches!(&spec.subject, Subject::Trait(own) if own == name);
        self.specs.iter().filter(|spec| spec.is_sampled).filter(is_it).find(|spec| spec.group(method).is_some())
    }

    /// The methods of that name of a type: inherent ones, then those of its traits.
    #[must_use]
    pub fn methods(&self, ty: &Ty, name: &str) -> Vec<MethodOwner> {
        match ty {
            Ty::Param(param) => self.bound_methods(&param.bounds, name, true, 0),
            Ty::Opaque(bounds) => self.bound_methods(bounds, name, false, 0),
            _ => self.impl_methods(ty, name),
        }
    }

    /// What a `for` loop calls to iterate over a value of the type: the `into_iter` of an impl in the analysed code.
    #[must_use]
    pub fn own_into_iter(&self, ty: &Ty) -> Option<FunctionId> {
        if !matches!(ty.peel(), Ty::Adt(..)) {
            return None;
        }
        // What an iterator of a crate that is not read lends cannot be told.
        if matches!(self.project(ty, "IntoIter"), Ty::External(path, _) if !path.starts_with("std::")) {
            return None;
        }
        let is_std = |owner: &MethodOwner| matches!(owner.of_trait(), Some(TraitName::External(path)) if path.ends_with("::IntoIterator"));
        self.impl_methods(ty, "into_iter").into_iter().filter(is_std).find_map(|owner| owner.function())
    }

    /// What `into` may run on a value of the type: the `From` impls of the analysed code that take it.
    #[must_use]
    pub fn conversions(&self, ty: &Ty) -> Vec<FunctionId> {
        let is_from =
            |def: &&ImplDef| matches!(&def.implements, Some(TraitName::External(path)) if path.ends_with("::From"));
        let takes_it = |function: &FunctionId| {
            let given = self.function(*function).function.params.first();
            let given = given.map(|given| self.lower(given, &self.scope_of(*function)));
            given.is_some_and(|given| matches!(given, Ty::Adt(..)) && given.may_be(ty))
        };
        let from = self.impls.iter().filter(is_from).filter_map(|def| def.methods.get("from").copied());
        from.filter(takes_it).collect()
    }

    fn impl_methods(&self, ty: &Ty, name: &str) -> Vec<MethodOwner> {
        let mut impls = self.impls_of(ty);
        // `impl Robot<Armed>` says nothing of a `Robot<Safe>`.
        impls.retain(|id| self.may_cover(*id, ty));
        let mut found = Vec::new();
        for id in &impls {
            let def = self.impl_def(*id);
            if def.trait_path.is_none()
                && let Some(function) = def.methods.get(name)
            {
                found.push(MethodOwner::Inherent(*function));
            }
        }
        for id in &impls {
            let def = self.impl_def(*id);
            let Some(implements) = &def.implements else { continue };
            if let Some(function) = def.methods.get(name) {
                found.push(MethodOwner::Implemented(implements.clone(), *function));
            } else if let TraitName::Local(of) = implements
                && let Some(function) = self.trait_def(*of).methods.get(name)
            {
                found.push(MethodOwner::Implemented(implements.clone(), *function));
            } else if let TraitName::External(path) = implements
                && self.is_external_law(path, name)
            {
                found.push(MethodOwner::Declared(implements.clone(), None));
            }
        }
        found
    }

    /// The constants of that name that the impls of the type itself have.
    pub fn constants_of<'a>(&'a self, ty: &Ty, name: &'a str) -> impl Iterator<Item = ValueId> + use<'a> {
        let impls = match ty {
            Ty::Adt(id, _) => self.impls_of_type.get(id),
            _ => None,
        };
        impls.into_iter().flatten().filter_map(move |of| self.impl_def(*of).consts.get(name).copied())
    }

    /// The numbers that a constant is in the impls of the trait among these that has it; `None` where one is not known.
    pub fn constants_behind(
        &self,
        bounds: &[TraitRef],
        name: &str,
        is_asked: impl Fn(TraitId) -> bool,
    ) -> Option<Vec<u64>> {
        let asked = bounds.iter().filter(|bound| matches!(bound.name, TraitName::Local(id) if is_asked(id)));
        let of_trait = |bound: &TraitRef| {
            self.impls.iter().filter(|def| def.implements.as_ref() == Some(&bound.name)).collect::<Vec<_>>()
        };
        let impls = asked.map(of_trait).find(|impls| impls.iter().any(|def| def.consts.contains_key(name)))?;
        impls.iter().map(|def| def.consts.get(name).and_then(|id| self.const_number(*id))).collect()
    }

    fn bound_methods(&self, bounds: &[TraitRef], name: &str, is_param: bool, depth: u32) -> Vec<MethodOwner> {
        let mut found = Vec::new();
        if depth > 8 {
            return found;
        }
        for bound in bounds {
            match &bound.name {
                TraitName::Local(id) => {
                    let def = self.trait_def(*id);
                    if let Some(function) = def.methods.get(name) {
                        found.push(MethodOwner::Declared(bound.name.clone(), Some(*function)));
                    }
                    let scope = self.scope(def.module, Owner::Module, Some(&def.generics));
                    let supertraits = self.lower_bounds(&def.supertraits, &scope, 0);
                    found.extend(self.bound_methods(&supertraits, name, is_param, depth + 1));
                    // A blanket impl gives its methods to everything that has the bound.
                    for blanket in &self.blankets {
                        let def = self.impl_def(*blanket);
                        if let (Ty::Param(param), Some(implements)) = (&def.self_ty, &def.implements)
                            && param.bounds.iter().any(|asked| asked.name == bound.name)
                            && let Some(function) = def.methods.get(name)
                        {
                            found.push(MethodOwner::Implemented(implements.clone(), *function));
                        }
                    }
                }
                TraitName::External(path) => {
                    let is_law = self.is_external_law(path, name) || self.is_law_by_type(&bound.name, name);
                    if is_law || is_param && !self.foreign_bodies(path, name).is_empty() {
                        found.push(MethodOwner::Declared(bound.name.clone(), None));
                    }
                }
            }
        }
        found
    }

    /// Every body that a method declared by a trait may run: the impls' own, or the default where an impl has none.
    #[must_use]
    pub fn implementations(&self, name: &TraitName, method: &str) -> Vec<FunctionId> {
        let TraitName::Local(id) = name else {
            // Of a trait that is not read, only those are asked for that may be a law.
            let of_trait = self.impls.iter().filter(|def| def.implements.as_ref() == Some(name));
            let own = of_trait.filter(|_| self.is_law_by_type(name, method)).filter_map(|def| def.methods.get(method));
            return own.copied().collect();
        };
        let default = self.trait_def(*id).methods.get(method).copied();
        let mut found: Vec<FunctionId> = Vec::new();
        let impls = self.impls_of_trait.get(id).map_or(&[][..], Vec::as_slice);
        for impl_id in impls {
            let own = self.impl_def(*impl_id).methods.get(method).copied();
            if let Some(function) = own.or(default)
                && !found.contains(&function)
            {
                found.push(function);
            }
        }
        found
    }

    /// The bodies that a method of a trait which is not read has in the analysed code: those of all types there that have the trait,
    /// unless one of them may have another body, by default or by what derives it. What the standard library's types do is no matter
    /// of those.
    #[must_use]
    pub fn foreign_bodies(&self, path: &str, method: &str) -> Vec<FunctionId> {
        let is_std = path.starts_with("std::") || path.starts_with("core::") || path.starts_with("alloc::");
        let name = path.rsplit("::").next().unwrap_or_default();
        if is_std || self.is_external_law(path, method) || self.derived.contains(name) {
            return Vec::new();
        }
        let impls = self.impls_of_foreign.get(path).into_iter().flatten().map(|id| self.impl_def(*id));
        let is_test = |def: &&ImplDef| {
            self.crate_of(def.module).is_test || def.methods.values().any(|id| self.function(*id).is_test)
        };
        let bodies = impls.filter(|def| !is_test(def)).map(|def| def.methods.get(method).copied());
        bodies.collect::<Option<Vec<_>>>().unwrap_or_default()
    }

    /// The types of the analysed code that may be behind a trait object or a type parameter, those of tests left out.
    #[must_use]
    pub fn types_behind(&self, ty: &Ty) -> Arc<[Ty]> {
        let bounds = match ty {
            Ty::Param(param) => &param.bounds,
            Ty::Opaque(bounds) => &**bounds,
            _ => return Arc::default(),
        };
        if let Some(known) = self.behind.read().ok().and_then(|known| known.get(ty).cloned()) {
            return known;
        }
        let found: Arc<[Ty]> = self.find_types_behind(bounds).into();
        if let Ok(mut known) = self.behind.write() {
            known.insert(ty.clone(), Arc::clone(&found));
        }
        found
    }

    fn find_types_behind(&self, bounds: &[TraitRef]) -> Vec<Ty> {
        let locals = bounds.iter().filter(|bound| matches!(bound.name, TraitName::Local(_)));
        // Of a trait that is not read, those matter that are filters by themselves.
        let foreign = bounds.iter().filter(|bound| matches!(bound.name, TraitName::External(_)));
        let mut found: Vec<Ty> = foreign.flat_map(|bound| self.filters_with(&bound.name)).collect();
        for bound in locals.clone() {
            let TraitName::Local(id) = bound.name else { continue };
            for def in self.impls_of_trait.get(&id).into_iter().flatten().map(|id| self.impl_def(*id)) {
                let is_test =
                    self.crate_of(def.module).is_test || def.methods.values().any(|id| self.function(*id).is_test);
                let has_all = || locals.clone().all(|bound| self.implements(&def.self_ty, &bound.name));
                if matches!(def.self_ty, Ty::Adt(..)) && !is_test && !found.contains(&def.self_ty) && has_all() {
                    found.push(def.self_ty.clone());
                }
            }
        }
        found
    }

    /// Whether the type has an impl that is not for a concrete type only: `impl Trait for T`.
    #[must_use]
    pub fn is_blanket(&self, id: ImplId) -> bool {
        matches!(self.impl_def(id).self_ref, TypeRef::Path(_)) && matches!(self.impl_def(id).self_ty, Ty::Param(_))
    }
}

/// Traits that are taken to hold for every type.
fn is_auto(path: &str) -> bool {
    matches!(path, "std::marker::Send" | "std::marker::Sync" | "std::marker::Sized" | "std::marker::Unpin")
}
