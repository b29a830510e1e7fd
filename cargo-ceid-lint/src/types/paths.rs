//! Paths in expressions: the variable, the item, or the member of a type that is meant.

use super::Resolved;
use super::infer::Infer;
use crate::index::{Def, FunctionId, MethodOwner, Namespace, Owner, TraitName, Ty};
use crate::syntax::tree::{ExprId, Path, TypeRef};

/// What a path in an expression means.
pub(super) enum Value {
    Local(super::LocalId),
    Def(Def),
    /// `Type::name`, `<T as Trait>::name`, `Trait::name`; the type if it is known.
    Assoc(Vec<MethodOwner>, Option<Ty>),
    /// `Type::name` of a type outside the analysed code.
    ExternalAssoc(Ty, String),
    Unknown,
}

impl Infer<'_> {
    pub(super) fn path_expr(&mut self, id: ExprId, path: &Path) -> Ty {
        match self.value_path(path) {
            Value::Local(local) => {
                self.typed.expr_local.insert(id, local);
                self.typed.locals[local.0 as usize].ty.clone()
            }
            // A parameter hides a constant of its name.
            Value::Def(_) if self.scope.declares_length(&path.text()) => Ty::Int,
            Value::Def(def) => {
                self.typed.expr_def.insert(id, def.clone());
                if let (Def::External(_), [.., _, _]) = (&def, path.segments.as_slice()) {
                    let mut owner = path.clone();
                    owner.segments.pop();
                    let owner = self.index.lower(&TypeRef::Path(owner), &self.scope);
                    if let Some(constant) = self.constant_of_unread(&owner, path.last()) {
                        return constant;
                    }
                }
                if let Def::Function(function) = def {
                    self.typed.items.insert(id, self.function_item(function));
                }
                self.def_ty(&def)
            }
            Value::Assoc(owners, ty) => {
                let function = owners.first().and_then(MethodOwner::function);
                if let Some(owner) = owners.into_iter().next() {
                    let resolved = self.assoc_item(owner, ty.unwrap_or(Ty::Unknown), path.last());
                    self.typed.items.insert(id, resolved);
                }
                function.map_or(Ty::Unknown, Ty::FunctionItem)
            }
            Value::ExternalAssoc(owner, name) => self.constant_of(id, &owner, &name),
            Value::Unknown => Ty::Unknown,
        }
    }

    /// The type of a constant that an impl of a type has.
    fn constant_of(&mut self, at: ExprId, owner: &Ty, name: &str) -> Ty {
        let mut constants = self.index.constants_of(owner, name);
        let Some(id) = constants.next() else {
            return self.constant_of_unread(owner, name).unwrap_or(Ty::Unknown);
        };
        // Which one it is of several impls, only their parameters tell.
        if constants.next().is_none() {
            self.typed.expr_def.insert(at, Def::Value(id));
        }
        match self.def_ty(&Def::Value(id)) {
            // The parameters of the impl are not those of the code that names the constant.
            Ty::Adt(id, args) if !args.is_empty() => self.fresh_adt(id),
            ty => ty,
        }
    }

    /// What a call of a function runs, wherever it is called.
    pub(super) fn function_item(&self, function: FunctionId) -> Resolved {
        let def = self.index.function(function);
        match def.owner {
            Owner::Module => Resolved {
                targets: vec![function],
                owner: None,
                law: None,
                self_ty: Ty::Unknown,
                has_receiver: def.function.receiver.is_some(),
                derefs: Vec::new(),
            },
            Owner::Impl(id) => {
                let of = self.index.impl_def(id);
                let owner = match &of.implements {
                    Some(name) => MethodOwner::Implemented(name.clone(), function),
                    None => MethodOwner::Inherent(function),
                };
                self.assoc_item(owner, of.self_ty.clone(), &def.name)
            }
            Owner::Trait(of) => {
                let owner = MethodOwner::Declared(TraitName::Local(of), Some(function));
                self.assoc_item(owner, Ty::Unknown, &def.name)
            }
        }
    }

    fn assoc_item(&self, owner: MethodOwner, self_ty: Ty, name: &str) -> Resolved {
        let law = self.law_of(&self_ty, name, &owner);
        let has_receiver = match owner.function() {
            Some(function) => self.index.function(function).function.receiver.is_some(),
            None => true,
        };
        let targets = self.targets(&owner, name);
        Resolved { targets, owner: Some(owner), law, self_ty, has_receiver, derefs: Vec::new() }
    }

    fn def_ty(&mut self, def: &Def) -> Ty {
        match def {
            Def::Function(id) => Ty::FunctionItem(*id),
            Def::Value(id) => {
                let value = self.index.value(*id);
                let scope = self.index.scope(value.module, value.owner, None);
                self.index.lower(&value.item.ty, &scope)
            }
            Def::Variant(id, _) | Def::Type(id) => {
                if self.field_count(def) == 0 {
                    self.fresh_adt(*id)
                } else {
                    Ty::Unknown
                }
            }
            Def::External(path) if path.ends_with("::None") => {
                Ty::std("std::option::Option", vec![self.variables.fresh()])
            }
            Def::External(_) | Def::Module(_) | Def::Alias(_) | Def::Trait(_) => Ty::Unknown,
        }
    }

    pub(super) fn fresh_adt(&mut self, id: crate::index::TypeId) -> Ty {
        let params = self.index.type_def(id).generics.params.len();
        Ty::Adt(id, (0..params).map(|_| self.variables.fresh()).collect())
    }

    pub(super) fn value_path(&mut self, path: &Path) -> Value {
        if let Some(name) = path.ident()
            && let Some(local) = self.lookup(name)
        {
            return Value::Local(local);
        }
        if path.ident() == Some("Self")
            && let Some(Ty::Adt(id, _)) = &self.scope.self_ty
        {
            return Value::Def(Def::Type(*id));
        }
        if path.self_ty.is_none()
            && let Some(def) = self.path_def(path)
            && matches!(def, Def::Function(_) | Def::Value(_) | Def::Variant(..) | Def::Type(_))
        {
            return Value::Def(def);
        }
        self.assoc_path(path)
    }

    /// `Type::name` in all its spellings.
    fn assoc_path(&mut self, path: &Path) -> Value {
        let name = path.last().to_owned();
        let owner = if let Some(self_ty) = &path.self_ty {
            let ty = self.index.lower(self_ty, &self.scope);
            if path.trait_segments > 0 {
                let of = Path { segments: path.segments[..path.trait_segments].to_vec(), ..Path::default() };
                // Of a derived `Default`, the function is not known, and the type is.
                let is_derived = name == "default" && self.index.methods(&ty, &name).is_empty();
                let of = self.index.trait_name(self.module(), &of);
                if let Some(of) = of.filter(|of| !(is_derived && matches!(of, TraitName::External(_)))) {
                    return Value::Assoc(self.trait_member(&of, &name, Some(&ty)), Some(ty));
                }
            }
            ty
        } else {
            let mut prefix = path.clone();
            prefix.segments.pop();
            if prefix.segments.is_empty() {
                return match self.path_def(path) {
                    Some(def) => Value::Def(def),
                    None => Value::Unknown,
                };
            }
            let names: Vec<String> = prefix.segments.iter().map(|segment| segment.name.clone()).collect();
            match self.index.resolve(self.module(), &names, Namespace::Type) {
                Some(Def::Trait(id)) => {
                    return Value::Assoc(self.trait_member(&TraitName::Local(id), &name, None), None);
                }
                Some(Def::External(external)) => {
                    if self.index.is_external_law(&external, &name) {
                        let owner = MethodOwner::Declared(TraitName::External(external), None);
                        return Value::Assoc(vec![owner], None);
                    }
                    // `mem::replace` is a function in a module, `Poll::Ready` a variant; neither is a type's function.
                    let is_module =
                        external.rsplit("::").next().is_some_and(|last| last.starts_with(char::is_lowercase));
                    if is_module || name.starts_with(char::is_uppercase) {
                        return Value::Def(Def::External(format!("{external}::{name}")));
                    }
                    self.index.lower(&TypeRef::Path(prefix), &self.scope)
                }
                _ => self.index.lower(&TypeRef::Path(prefix), &self.scope),
            }
        };
        let owner = self.open(&owner);
        let owners = self.in_scope_here(self.index.methods(&owner, &name));
        if owners.is_empty() {
            return match owner {
                Ty::External(..) | Ty::Adt(..) => Value::ExternalAssoc(owner, name),
                Ty::Param(_) | Ty::Opaque(_) if name == "default" => Value::ExternalAssoc(owner, name),
                _ => match self.path_def(path) {
                    Some(def) => Value::Def(def),
                    None => Value::Unknown,
                },
            };
        }
        Value::Assoc(owners, Some(owner))
    }

    fn trait_member(&self, of: &TraitName, name: &str, ty: Option<&Ty>) -> Vec<MethodOwner> {
        if let Some(ty) = ty {
            let own: Vec<MethodOwner> =
                self.index.methods(ty, name).into_iter().filter(|owner| owner.of_trait() == Some(of)).collect();
            if !own.is_empty() {
                return own;
            }
        }
        match of {
            TraitName::Local(id) => match self.index.trait_def(*id).methods.get(name) {
                Some(function) => vec![MethodOwner::Declared(of.clone(), Some(*function))],
                None => Vec::new(),
            },
            TraitName::External(_) => vec![MethodOwner::Declared(of.clone(), None)],
        }
    }
}
