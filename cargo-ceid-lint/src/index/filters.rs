//! Which types are filters, and what their update law is.

use super::{Index, MethodOwner, TraitId, TraitName, Ty, is_sampled_filter_path};

/// A filter type, or a trait whose types are filters, with its law.
#[derive(Clone, Debug)]
pub struct FilterSpec {
    /// What it is known by.
    pub subject: Subject,
    /// The halves of the law; most laws have one.
    pub law: Vec<LawGroup>,
    /// Methods that reset the whole state; a reset of a type known by trait is judged by its body.
    pub resets: Vec<String>,
}

/// What a filter type is known by.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Subject {
    /// Every type that implements the trait.
    Trait(TraitName),
    /// One type of the analysed code.
    Type(super::TypeId),
    /// One type of a crate whose sources are not read, by its path.
    External(String),
}

/// A law, or a half of one: its methods are alternatives, one of which runs.
#[derive(Clone, Debug)]
pub struct LawGroup {
    /// The methods.
    pub methods: Vec<String>,
    /// How often one of them may run.
    pub multiplicity: Multiplicity,
}

/// How often a half of a law may run in a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Multiplicity {
    /// Exactly once.
    Once,
    /// Not twice.
    AtMostOnce,
    /// As often as one likes.
    Any,
}

/// A filter is known by `SampledFilter`: ceid-core's, or a trait of that name in the analysed code.
pub(super) fn specs(index: &Index) -> Vec<FilterSpec> {
    let mut traits: Vec<TraitName> = (0u32..)
        .zip(&index.traits)
        .filter(|(_, def)| def.name == "SampledFilter")
        .map(|(number, _)| TraitName::Local(TraitId(number)))
        .collect();
    for def in &index.impls {
        if let Some(TraitName::External(path)) = &def.implements
            && is_sampled_filter_path(path)
        {
            traits.push(TraitName::External(path.clone()));
        }
    }
    traits.push(TraitName::External("ceid_core::SampledFilter".to_owned()));
    traits.dedup();
    traits
        .into_iter()
        .map(|name| FilterSpec {
            subject: Subject::Trait(name),
            law: vec![LawGroup { methods: vec!["update".to_owned()], multiplicity: Multiplicity::Once }],
            resets: vec!["reset".to_owned()],
        })
        .collect()
}

impl Index {
    /// Makes a filter of the type or trait that a path means in the module, if it means one.
    pub fn add_filter(&mut self, module: super::ModuleId, path: &str, law: &[Vec<String>], resets: &[String]) {
        let names: Vec<String> = path.split("::").map(str::to_owned).collect();
        let subject = match self.resolve(module, &names, super::Namespace::Type) {
            Some(super::Def::Type(id)) => Subject::Type(id),
            Some(super::Def::Trait(id)) => Subject::Trait(TraitName::Local(id)),
            Some(super::Def::External(path)) => Subject::External(path),
            _ => return,
        };
        if self.specs.iter().any(|spec| spec.subject == subject) {
            return;
        }
        let law =
            law.iter().map(|methods| LawGroup { methods: methods.clone(), multiplicity: Multiplicity::Once }).collect();
        self.specs.insert(0, FilterSpec { subject, law, resets: resets.to_vec() });
    }

    /// Finds the types that hold filters. Has to be called again when a filter was added.
    pub fn find_holders(&mut self) {
        let mut fields: Vec<(super::TypeId, Vec<Ty>)> = Vec::new();
        for (number, def) in (0u32..).zip(&self.types) {
            let scope = self.scope(def.module, super::Owner::Module, Some(&def.generics));
            let of = |fields: &crate::syntax::tree::Fields| -> Vec<Ty> {
                fields.fields.iter().map(|field| self.lower(&field.ty, &scope)).collect()
            };
            let all = match &def.shape {
                super::Shape::Struct(shape) => of(shape),
                super::Shape::Enum(variants) => variants.iter().flat_map(|variant| of(&variant.fields)).collect(),
            };
            fields.push((super::TypeId(number), all));
        }
        self.holding.clear();
        loop {
            let found: Vec<super::TypeId> = fields
                .iter()
                .filter(|(id, all)| {
                    let args = vec![Ty::Unknown; self.type_def(*id).generics.params.len()];
                    !self.holding.contains(id)
                        && (self.filter_spec(&Ty::Adt(*id, args)).is_some()
                            || all.iter().any(|ty| self.holds_filter(ty)))
                })
                .map(|(id, _)| *id)
                .collect();
            if found.is_empty() {
                return;
            }
            self.holding.extend(found);
        }
    }

    /// Whether a type is a filter or holds one, as far as is known.
    #[must_use]
    pub fn holds_filter(&self, ty: &Ty) -> bool {
        match ty {
            Ty::Adt(id, args) => self.holding.contains(id) || args.iter().any(|arg| self.holds_filter(arg)),
            Ty::External(_, args) => self.filter_spec(ty).is_some() || args.iter().any(|arg| self.holds_filter(arg)),
            Ty::Ref(_, inner) | Ty::Pointer(inner) | Ty::Array(inner, _) | Ty::Slice(inner) => self.holds_filter(inner),
            Ty::Tuple(parts) => parts.iter().any(|part| self.holds_filter(part)),
            Ty::Param(_) | Ty::Opaque(_) => self.filter_spec(ty).is_some(),
            _ => false,
        }
    }

    /// What is known of a type as a filter; `None` if it is none.
    #[must_use]
    pub fn filter_spec(&self, ty: &Ty) -> Option<&FilterSpec> {
        if !matches!(ty, Ty::Adt(..) | Ty::External(..) | Ty::Param(_) | Ty::Opaque(_)) {
            return None;
        }
        self.specs.iter().find(|spec| match &spec.subject {
            // `impl<F: SampledFilter> SampledFilter for Option<F>` makes no filter of every option: its content is looked at.
            Subject::Trait(name) => {
                let is_std = matches!(ty, Ty::External(path, _) if path.starts_with("std::"));
                !is_std && self.implements(ty, name)
            }
            Subject::Type(id) => matches!(ty, Ty::Adt(own, _) if own == id),
            Subject::External(path) => matches!(ty, Ty::External(own, _) if own == path),
        })
    }

    /// The half of the law that a method of a filter runs: its number, if it is one.
    #[must_use]
    pub fn law_group(&self, spec: &FilterSpec, method: &str, owner: &MethodOwner) -> Option<usize> {
        // A method of the same name of another trait is another method.
        if let Subject::Trait(of) = &spec.subject
            && owner.of_trait().is_some_and(|name| name != of && !self.is_filter_trait(name))
        {
            return None;
        }
        spec.law.iter().position(|group| group.methods.iter().any(|name| name == method))
    }

    /// Whether a trait makes filters of its types.
    #[must_use]
    pub fn is_filter_trait(&self, name: &TraitName) -> bool {
        self.specs.iter().any(|spec| matches!(&spec.subject, Subject::Trait(of) if of == name))
    }

    /// How many filter types the analysed code has.
    #[must_use]
    pub fn filter_type_count(&self) -> usize {
        (0u32..)
            .zip(&self.types)
            .filter(|(number, def)| {
                let args = vec![Ty::Unknown; def.generics.params.len()];
                self.filter_spec(&Ty::Adt(super::TypeId(*number), args)).is_some()
            })
            .count()
    }
}
