//! Which types are filters, and what their update law is.

use super::{
    Def, FunctionId, Index, MethodOwner, Owner, TraitId, TraitName, Ty, TypeDef, TypeId, is_sampled_filter_path,
};
use crate::config::{FilterEntry, FilterKind, InstancePlace, Multiplicity, OnErr, Receiver, TimeBase, Word};

/// A filter type, or a trait whose types are filters, with its law.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FilterSpec {
    /// What it is known by.
    pub subject: Subject,
    /// The halves of the law; most laws have one.
    pub law: Vec<LawGroup>,
    /// Where the instance is in a call of the law.
    pub instance: InstancePlace,
    /// The arguments that select a channel, each of which is an instance of its own.
    pub key: Vec<u32>,
    /// Whether the law takes `&mut self`.
    pub receiver: Receiver,
    /// Methods that reset the whole state.
    pub resets: Vec<String>,
    /// Methods that reset a part of the state.
    pub partial_resets: Vec<String>,
    /// What an `Err` of the law means.
    pub on_err: OnErr,
    /// Where the time step comes from; `None` if the law's parameters tell.
    pub time_base: Option<TimeBase>,
    /// Whether it is checked at all: what is driven by events is known, and not checked.
    pub is_sampled: bool,
    /// Whether only a preset says so.
    pub is_preset: bool,
}

/// What a filter type is known by.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Subject {
    /// Every type that implements the trait.
    Trait(TraitName),
    /// One type of the analysed code.
    Type(TypeId),
    /// One type of a crate whose sources are not read, by its path.
    External(String),
    /// A free function whose argument or result is the state.
    Function(Def),
}

/// A law, or a half of one: its methods are alternatives, one of which runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LawGroup {
    /// The methods.
    pub methods: Vec<String>,
    /// How often one of them may run.
    pub multiplicity: Multiplicity,
}

impl FilterSpec {
    /// What is known by the trait alone.
    fn by_trait(name: TraitName) -> Self {
        Self {
            subject: Subject::Trait(name),
            law: vec![LawGroup { methods: vec!["update".to_owned()], multiplicity: Multiplicity::Once }],
            instance: InstancePlace::Receiver,
            key: Vec::new(),
            receiver: Receiver::Exclusive,
            resets: vec!["reset".to_owned()],
            partial_resets: Vec::new(),
            on_err: OnErr::Updated,
            time_base: None,
            is_sampled: true,
            is_preset: false,
        }
    }

    pub(super) fn by_entry(subject: Subject, entry: &FilterEntry) -> Self {
        let groups = entry.law.iter().zip(&entry.multiplicity);
        let texts = |words: &[Word]| words.iter().map(|word| word.text.clone()).collect::<Vec<_>>();
        let methods = |words: &[Word]| texts(words).into_iter().filter(|name| !name.contains("::")).collect();
        Self {
            subject,
            law: groups
                .map(|(methods, multiplicity)| LawGroup { methods: texts(methods), multiplicity: *multiplicity })
                .collect(),
            instance: entry.instance,
            key: entry.key.clone(),
            receiver: entry.receiver,
            resets: methods(&entry.reset),
            partial_resets: methods(&entry.partial_reset),
            on_err: entry.on_err,
            time_base: Some(entry.time_base),
            is_sampled: entry.kind == FilterKind::Sampled,
            is_preset: false,
        }
    }

    /// What a half is told by: the method that runs there, unless other halves have it as well, or else the first of its own.
    #[must_use]
    pub fn name_of(&self, half: usize, running: Option<&str>) -> Option<String> {
        let is_elsewhere = |method: &str| {
            let others = self.law.iter().enumerate().filter(|(number, _)| *number != half);
            others.flat_map(|(_, group)| &group.methods).any(|other| other == method)
        };
        if let Some(method) = running.filter(|method| !is_elsewhere(method)) {
            return Some(method.to_owned());
        }
        let methods = &self.law.get(half)?.methods;
        methods.iter().find(|method| !is_elsewhere(method)).or(methods.first()).cloned()
    }

    /// The half of the law that a method runs.
    #[must_use]
    pub fn group(&self, method: &str) -> Option<usize> {
        self.law.iter().position(|group| group.methods.iter().any(|name| name == method))
    }
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
    traits.into_iter().map(FilterSpec::by_trait).collect()
}

impl Index {
    /// Finds the types that hold filters. Has to be called again when a filter was added.
    pub fn find_holders(&mut self) {
        self.states = self.find_states();
        self.share_laws();
        let mut fields: Vec<(TypeId, Vec<Ty>)> = Vec::new();
        for (number, def) in (0u32..).zip(&self.types) {
            let scope = self.scope(def.module, Owner::Module, Some(&def.generics));
            let of = |fields: &crate::syntax::tree::Fields| -> Vec<Ty> {
                fields.fields.iter().map(|field| self.lower(&field.ty, &scope)).collect()
            };
            let all = match &def.shape {
                super::Shape::Struct(shape) => of(shape),
                super::Shape::Enum(variants) => variants.iter().flat_map(|variant| of(&variant.fields)).collect(),
            };
            if matches!(def.shape, super::Shape::Struct(_)) {
                let kept = all.iter().filter_map(|ty| if let Ty::Adt(id, _) = ty { Some(*id) } else { None });
                self.kept.extend(kept);
            }
            fields.push((TypeId(number), all));
        }
        self.leading = super::owned::Leading::find(self, &fields);
        self.holding.clear();
        loop {
            let found: Vec<TypeId> = fields
                .iter()
                .filter(|(id, all)| {
                    let args = vec![Ty::Unknown; self.type_def(*id).generics.params.len()];
                    !self.holding.contains(id)
                        && self.guard_spec(&Ty::Adt(*id, Vec::new())).is_none()
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

    /// Whether a type is an enum of messages: several of its variants carry something, and no struct keeps one, as it would
    /// keep a state.
    #[must_use]
    pub fn is_message(&self, ty: &Ty) -> bool {
        let Ty::Adt(id, _) = ty.peel() else { return false };
        let super::Shape::Enum(variants) = &self.type_def(*id).shape else { return false };
        let carrying = variants.iter().filter(|variant| !variant.fields.fields.is_empty());
        carrying.count() > 1 && !self.is_kept(*id)
    }

    /// Whether some struct has a field of the type.
    #[must_use]
    pub fn is_kept(&self, id: TypeId) -> bool {
        self.kept.contains(&id)
    }

    /// Whether a type is a filter or the state of a law, or holds one, as far as is known.
    #[must_use]
    pub fn holds_filter(&self, ty: &Ty) -> bool {
        if self.guard_spec(ty).is_some() {
            return false;
        }
        match ty {
            Ty::Adt(id, args) => self.holding.contains(id) || args.iter().any(|arg| self.holds_filter(arg)),
            Ty::External(_, args) => self.filter_spec(ty).is_some() || args.iter().any(|arg| self.holds_filter(arg)),
            Ty::Ref(_, inner) | Ty::Pointer(inner) | Ty::Array(inner, _) | Ty::Slice(inner) => self.holds_filter(inner),
            Ty::Tuple(parts) => parts.iter().any(|part| self.holds_filter(part)),
            Ty::Param(_) | Ty::Opaque(_) => self.filter_spec(ty).is_some(),
            _ => false,
        }
    }

    /// Whether the filters that a value of the type leads to all lie behind references, so that moving it moves none of them.
    #[must_use]
    pub fn refers_to_filters(&self, ty: &Ty) -> bool {
        self.holds_filter(ty) && self.only_refers(ty, 0)
    }

    fn only_refers(&self, ty: &Ty, depth: u32) -> bool {
        match ty {
            Ty::Ref(..) => true,
            Ty::Pointer(_) => false,
            // What a variant refers to has no name where the value goes.
            Ty::Adt(id, _) if matches!(self.type_def(*id).shape, super::Shape::Enum(_)) => false,
            _ => self.is_all_of_filters(ty, depth, Self::only_refers),
        }
    }

    /// Whether a shared reference to a value of the type leaves the filters in it alone, for none of them lies behind a lock.
    #[must_use]
    pub fn shares_no_filter(&self, ty: &Ty, is_lock: fn(&Ty) -> bool) -> bool {
        !self.holds_filter(ty) || self.locks_none(ty, is_lock, 0)
    }

    fn locks_none(&self, ty: &Ty, is_lock: fn(&Ty) -> bool, depth: u32) -> bool {
        match ty {
            _ if is_lock(ty) => false,
            _ if self.filter_spec(ty).is_some_and(|spec| spec.receiver != Receiver::Shared) => true,
            Ty::Ref(_, inner) => self.locks_none(inner, is_lock, depth),
            _ => self.is_all_of_filters(ty, depth, |index, part, depth| index.locks_none(part, is_lock, depth)),
        }
    }

    /// Whether a clone of a value of the type leads to the same filters: all of them lie behind handles.
    #[must_use]
    pub fn is_handle(&self, ty: &Ty) -> bool {
        self.holds_filter(ty) && self.is_made_of_handles(ty, 0)
    }

    fn is_made_of_handles(&self, ty: &Ty, depth: u32) -> bool {
        match ty {
            _ if ty.is_shared_pointer() || self.shares_state(ty) => true,
            Ty::Adt(..) if !self.derives(ty, "std::clone::Clone") => false,
            _ => self.is_all_of_filters(ty, depth, Self::is_made_of_handles),
        }
    }

    /// Whether a filter is a handle to its own state, so that its clones are the same filter: its law takes `&self`, and what that
    /// changes lies behind a pointer that several own. Of a type that is not read, the law alone tells it.
    #[must_use]
    pub fn shares_state(&self, ty: &Ty) -> bool {
        let is_apart =
            |part: &mut dyn FnMut(&Ty) -> bool, field: &Ty| field.is_shared_pointer() || !field.has_part(part);
        let is_cell = &mut |part: &Ty| matches!(part.external_name(), Some("Cell" | "RefCell" | "OnceCell"));
        if self.receiver_spec(ty).is_none_or(|spec| spec.receiver != Receiver::Shared) {
            return false;
        }
        match ty {
            Ty::External(..) => true,
            Ty::Adt(id, _) if self.derives(ty, "std::clone::Clone") => {
                let super::Shape::Struct(fields) = &self.type_def(*id).shape else { return false };
                let fields: Vec<Ty> =
                    fields.fields.iter().filter_map(|field| self.field_ty(ty, None, &field.name)).collect();
                fields.iter().any(Ty::is_shared_pointer) && fields.iter().all(|field| is_apart(is_cell, field))
            }
            _ => false,
        }
    }

    /// Whether something holds of all parts of a value that lead to filters, as far as its type tells them.
    fn is_all_of_filters(&self, ty: &Ty, depth: u32, holds: impl Fn(&Self, &Ty, u32) -> bool) -> bool {
        const MAX_DEPTH: u32 = 6;
        if depth > MAX_DEPTH {
            return false;
        }
        let go = |ty: &Ty| !self.holds_filter(ty) || holds(self, ty, depth + 1);
        match ty {
            _ if self.filter_spec(ty).is_some() => false,
            Ty::Array(inner, _) | Ty::Slice(inner) => go(inner),
            Ty::Tuple(parts) => parts.iter().all(go),
            Ty::External(_, args) => args.iter().all(go),
            Ty::Adt(id, _) => match &self.type_def(*id).shape {
                super::Shape::Struct(fields) => {
                    fields.fields.iter().filter_map(|field| self.field_ty(ty, None, &field.name)).all(|ty| go(&ty))
                }
                super::Shape::Enum(variants) => variants.iter().enumerate().all(|(number, variant)| {
                    let mut fields = variant.fields.fields.iter();
                    fields.all(|field| self.field_ty(ty, Some(number), &field.name).is_some_and(|ty| go(&ty)))
                }),
            },
            _ => false,
        }
    }

    /// Whether a filter in a value of the type is another instance wherever the value goes.
    #[must_use]
    pub fn copies_filter(&self, ty: &Ty) -> bool {
        let leads_to_it = matches!(ty, Ty::Pointer(_)) || self.refers_to_filters(ty);
        (self.holds_filter(ty) || self.may_be_state(ty)) && self.is_copy(ty) && !leads_to_it
    }

    /// Whether a value of the type is copied where another one would be moved, as far as the analysed code tells.
    #[must_use]
    pub fn is_copy(&self, ty: &Ty) -> bool {
        match ty {
            Ty::Int | Ty::Float | Ty::Bool | Ty::Char | Ty::Never | Ty::Pointer(_) | Ty::FunctionItem(_) => true,
            Ty::Ref(is_mutable, _) => !is_mutable,
            Ty::Tuple(parts) => parts.iter().all(|part| self.is_copy(part)),
            Ty::Array(inner, _) => self.is_copy(inner),
            Ty::External(path, args) => {
                matches!(path.rsplit("::").next(), Some("Option" | "Result" | "Poll"))
                    && args.iter().all(|arg| self.is_copy(arg))
            }
            Ty::Adt(_, args) => {
                self.implements(ty, &TraitName::External("std::marker::Copy".to_owned()))
                    && args.iter().all(|arg| self.is_copy(arg))
            }
            Ty::Param(_) | Ty::Opaque(_) => self.implements(ty, &TraitName::External("std::marker::Copy".to_owned())),
            _ => false,
        }
    }

    /// What is known of a type as a filter; `None` if it is none. A type whose law has its state elsewhere is none; the state is.
    #[must_use]
    pub fn filter_spec(&self, ty: &Ty) -> Option<&FilterSpec> {
        self.receiver_spec(ty).or_else(|| self.state_spec(ty))
    }

    /// What is known of a type whose law has `self` for its state.
    #[must_use]
    pub fn receiver_spec(&self, ty: &Ty) -> Option<&FilterSpec> {
        self.law_spec(ty).filter(|spec| spec.instance == InstancePlace::Receiver)
    }

    /// What is known of a type that has a law, wherever the law's state is.
    #[must_use]
    pub fn law_spec(&self, ty: &Ty) -> Option<&FilterSpec> {
        if !matches!(ty, Ty::Adt(..) | Ty::External(..) | Ty::Param(_) | Ty::Opaque(_)) {
            return None;
        }
        let by_name = |spec: &&FilterSpec| match &spec.subject {
            Subject::Type(id) => matches!(ty, Ty::Adt(own, _) if own == id),
            Subject::External(path) => matches!(ty, Ty::External(own, _) if own == path),
            Subject::Trait(_) | Subject::Function(_) => false,
        };
        // `impl<F: SampledFilter> SampledFilter for Option<F>` makes no filter of every option: its content is looked at.
        let is_std = matches!(ty, Ty::External(path, _) if path.starts_with("std::"));
        let by_trait = |spec: &&FilterSpec| match &spec.subject {
            Subject::Trait(name) => !is_std && self.implements(ty, name),
            _ => false,
        };
        // What the configuration says of the type itself stands over what it says of its traits, wherever it is written.
        let mut specs = self.specs.iter();
        let named = specs.find(|spec| !spec.is_preset && by_name(spec));
        let found = named.or_else(|| self.specs.iter().find(|spec| by_name(spec) || by_trait(spec)));
        found.filter(|spec| spec.is_sampled)
    }

    /// What is known of a filter of which only the trait is known.
    #[must_use]
    pub fn trait_spec(&self) -> &FilterSpec {
        self.specs.iter().find(|spec| spec.time_base.is_none()).expect("ceid-core's trait is always known")
    }

    /// Whether the state of some law is no receiver, so that a value of a type that is no filter may be one.
    #[must_use]
    pub fn has_states_apart(&self) -> bool {
        self.specs.iter().any(|spec| spec.is_sampled && spec.instance != InstancePlace::Receiver)
    }

    /// How many halves the law with the most halves has.
    #[must_use]
    pub fn halves(&self) -> usize {
        self.specs.iter().map(|spec| spec.law.len()).max().unwrap_or(1)
    }

    /// What is known of a free function as the law of its argument or result.
    #[must_use]
    pub fn function_spec(&self, def: &Def) -> Option<&FilterSpec> {
        self.specs.iter().find(|spec| spec.is_sampled && matches!(&spec.subject, Subject::Function(own) if own == def))
    }

    /// The half of the law that a method of a filter runs: its number, if it is one.
    #[must_use]
    pub fn law_group(&self, spec: &FilterSpec, method: &str, owner: &MethodOwner) -> Option<usize> {
        // A method of the same name of another trait is another method.
        if let Subject::Trait(of) = &spec.subject
            && owner
                .of_trait()
                .is_some_and(|name| name != of && !self.is_filter_trait(name) && !self.has_from(of, name, method))
        {
            return None;
        }
        spec.group(method)
    }

    /// Whether a trait has a method from a trait that it asks for, and none of that name itself.
    fn has_from(&self, of: &TraitName, asked: &TraitName, method: &str) -> bool {
        let TraitName::Local(id) = of else { return false };
        !self.trait_def(*id).methods.contains_key(method) && self.implied[id.0 as usize].contains(asked)
    }

    /// What is known of a type whose law a function is, and which half of it. What a trait that makes no filters declares beside an
    /// inherent law of the same name is no law: it may call that.
    #[must_use]
    pub fn law_run_by(&self, ty: &Ty, id: FunctionId) -> Option<(&FilterSpec, usize)> {
        let spec = self.receiver_spec(ty)?;
        let def = self.function(id);
        let of_trait = match def.owner {
            Owner::Impl(of) => self.impl_def(of).implements.clone(),
            Owner::Trait(of) => Some(TraitName::Local(of)),
            Owner::Module => return None,
        };
        let is_inherent = |own: &MethodOwner| matches!(own, MethodOwner::Inherent(_));
        let owner = match of_trait {
            None => MethodOwner::Inherent(id),
            Some(name) if !self.is_filter_trait(&name) && self.methods(ty, &def.name).iter().any(is_inherent) => {
                return None;
            }
            Some(name) => MethodOwner::Implemented(name, id),
        };
        Some((spec, self.law_group(spec, &def.name, &owner)?))
    }

    /// Whether a method that a trait outside the analysed code declares is a law.
    #[must_use]
    pub fn is_external_law(&self, path: &str, method: &str) -> bool {
        (is_sampled_filter_path(path) && method == "update")
            || self.specs.iter().any(|spec| {
                spec.is_sampled
                    && matches!(&spec.subject, Subject::Trait(TraitName::External(own)) if own == path)
                    && spec.group(method).is_some()
            })
    }

    /// Whether a type that is a filter by itself may have its law by a trait.
    #[must_use]
    pub fn is_law_by_type(&self, name: &TraitName, method: &str) -> bool {
        self.specs.iter().any(|spec| match spec.subject {
            Subject::Type(id) => spec.is_sampled && spec.group(method).is_some() && self.has_trait(id, name),
            _ => false,
        })
    }

    /// The types of the analysed code that are filters by themselves and have a trait.
    pub(super) fn filters_with<'a>(&'a self, name: &'a TraitName) -> impl Iterator<Item = Ty> + 'a {
        self.specs.iter().filter_map(move |spec| match spec.subject {
            Subject::Type(id) if spec.is_sampled && self.has_trait(id, name) => Some(self.bare(id)),
            _ => None,
        })
    }

    /// Whether a trait makes filters of its types.
    #[must_use]
    pub fn is_filter_trait(&self, name: &TraitName) -> bool {
        self.specs.iter().any(|spec| spec.is_sampled && matches!(&spec.subject, Subject::Trait(of) if of == name))
    }

    /// Whether a function is a law that guards run.
    #[must_use]
    pub fn is_run_by_guards(&self, function: FunctionId) -> bool {
        let def = self.function(function);
        let Owner::Impl(id) = def.owner else { return false };
        def.name == "update" && self.impl_def(id).implements.as_ref().is_some_and(|name| self.is_of_core(name))
    }

    /// Whether a trait is ceid-core's `SampledFilter`.
    #[must_use]
    pub fn is_of_core(&self, name: &TraitName) -> bool {
        match name {
            TraitName::External(path) => is_sampled_filter_path(path),
            TraitName::Local(id) => {
                let def = self.trait_def(*id);
                def.name == "SampledFilter" && self.crate_of(def.module).package_name == "ceid_core"
            }
        }
    }

    /// The filter types of the analysed code.
    pub fn filter_types(&self) -> impl Iterator<Item = &TypeDef> {
        let is_filter = |(number, def): &(u32, &TypeDef)| {
            let args = vec![Ty::Unknown; def.generics.params.len()];
            self.filter_spec(&Ty::Adt(TypeId(*number), args)).is_some()
        };
        (0u32..).zip(&self.types).filter(is_filter).map(|(_, def)| def)
    }

    /// How many of them there are.
    #[must_use]
    pub fn filter_type_count(&self) -> usize {
        self.filter_types().count()
    }
}
