//! Calls: which function or method is meant, and what it gives back.

use super::builtin;
use super::infer::{Infer, param_types};
use super::{Callee, Resolved};
use crate::index::{Def, FunctionId, MethodOwner, Namespace, Owner, ParamTy, TraitName, TraitRef, Ty};
use crate::syntax::tree::{ExprId, ExprKind, Path, TypeRef};

/// What a path in an expression means.
enum Value {
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
            Value::Def(def) => {
                self.typed.expr_def.insert(id, def.clone());
                self.def_ty(&def)
            }
            Value::Assoc(owners, _) => match owners.first().and_then(MethodOwner::function) {
                Some(function) => Ty::FunctionItem(function),
                None => Ty::Unknown,
            },
            Value::ExternalAssoc(..) | Value::Unknown => Ty::Unknown,
        }
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

    fn fresh_adt(&mut self, id: crate::index::TypeId) -> Ty {
        let params = self.index.type_def(id).generics.params.len();
        Ty::Adt(id, (0..params).map(|_| self.variables.fresh()).collect())
    }

    fn value_path(&mut self, path: &Path) -> Value {
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
                if let Some(of) = self.index.trait_name(self.module(), &of) {
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
                    if crate::index::is_sampled_filter_path(&external) {
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
        let owners = self.index.methods(&owner, &name);
        if owners.is_empty() {
            return match owner {
                Ty::External(..) | Ty::Adt(..) => Value::ExternalAssoc(owner, name),
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

    pub(super) fn call(&mut self, id: ExprId, callee: ExprId, args: &[ExprId], expected: Option<&Ty>) -> Ty {
        let body = self.body;
        if let ExprKind::Path(path) = &body.expr(callee).kind {
            let value = self.value_path(path);
            self.path_expr(callee, path);
            return self.call_value(id, value, path, args, expected);
        }
        let ty = self.expr(callee, None);
        self.call_of_type(id, &ty, args)
    }

    fn call_of_type(&mut self, id: ExprId, ty: &Ty, args: &[ExprId]) -> Ty {
        let ty = self.variables.shallow(ty).peel().clone();
        match ty {
            Ty::Closure(number) => {
                let given: Vec<Ty> = args.iter().map(|arg| self.expr(*arg, None)).collect();
                let closure = ExprId(number);
                if let Some(params) = self.closure_params.get(&closure).cloned() {
                    for (param, given) in params.iter().zip(&given) {
                        self.variables.unify(param, given);
                    }
                }
                self.typed.callees.insert(id, Callee::Closure(closure));
                self.closure_outputs.get(&closure).cloned().unwrap_or(Ty::Unknown)
            }
            Ty::FunctionItem(function) => self.call_function(id, function, None, args, None),
            Ty::Function(params, output) => {
                for (number, arg) in args.iter().enumerate() {
                    self.expr(*arg, params.get(number));
                }
                self.typed.callees.insert(id, Callee::Unknown);
                *output
            }
            _ => {
                for arg in args {
                    self.expr(*arg, None);
                }
                self.typed.callees.insert(id, Callee::Unknown);
                Ty::Unknown
            }
        }
    }

    fn call_value(&mut self, id: ExprId, value: Value, path: &Path, args: &[ExprId], expected: Option<&Ty>) -> Ty {
        match value {
            Value::Local(local) => {
                let ty = self.variables.shallow(&self.typed.locals[local.0 as usize].ty.clone()).peel().clone();
                match callable_bound(&ty) {
                    Some((params, output)) => {
                        for (number, arg) in args.iter().enumerate() {
                            self.expr(*arg, params.get(number));
                        }
                        self.typed.callees.insert(id, Callee::Parameter(local));
                        output
                    }
                    None => self.call_of_type(id, &ty, args),
                }
            }
            Value::Def(Def::Function(function)) => self.call_function(id, function, None, args, expected),
            Value::Def(def @ (Def::Variant(..) | Def::Type(_))) => {
                let (own, variant) = match &def {
                    Def::Variant(own, at) => (*own, Some(*at)),
                    Def::Type(own) => (*own, None),
                    _ => return Ty::Unknown,
                };
                let ty = self.fresh_adt(own);
                if let Some(expected) = expected {
                    self.variables.unify(&ty, expected);
                }
                for (number, arg) in args.iter().enumerate() {
                    let field = self.index.field_ty(&ty, variant, &number.to_string());
                    let found = self.expr(*arg, field.as_ref());
                    if let Some(field) = field {
                        self.variables.unify(&field, &found);
                    }
                }
                self.typed.callees.insert(id, Callee::Constructor(Some(def)));
                ty
            }
            Value::Def(Def::External(external)) => self.call_external(id, &external, args, expected),
            Value::Assoc(owners, ty) => {
                let Some(owner) = owners.into_iter().next() else { return Ty::Unknown };
                self.call_assoc(id, owner, ty, path.last(), args, expected)
            }
            Value::ExternalAssoc(ty, name) => self.call_external_assoc(id, ty, &name, args),
            Value::Def(_) | Value::Unknown => {
                for arg in args {
                    self.expr(*arg, None);
                }
                self.typed.callees.insert(id, Callee::Unknown);
                Ty::Unknown
            }
        }
    }

    /// `Type::name(args)`, where `self` may be the first argument.
    fn call_assoc(
        &mut self,
        id: ExprId,
        owner: MethodOwner,
        ty: Option<Ty>,
        name: &str,
        args: &[ExprId],
        expected: Option<&Ty>,
    ) -> Ty {
        let has_receiver = match owner.function() {
            Some(function) => self.index.function(function).function.receiver.is_some(),
            None => true,
        };
        let self_ty = if has_receiver {
            let found = args.first().map(|arg| self.expr(*arg, None)).unwrap_or(Ty::Unknown);
            let found = self.behind_pointers(&found);
            ty.clone().filter(|ty| !matches!(ty, Ty::Var(_))).unwrap_or(found)
        } else {
            match ty.clone() {
                Some(ty) => {
                    if let Some(expected) = expected {
                        self.unify_constructed(&owner, &ty, expected);
                    }
                    ty
                }
                None => Ty::Unknown,
            }
        };
        let owner = self.specialise(owner, &self_ty, name);
        let law = self.law_of(&self_ty, name, &owner);
        let targets = self.targets(&owner, name);
        let output = match owner.function() {
            Some(function) => self.instantiate(function, Some(&self_ty), args, has_receiver, expected),
            None => {
                for arg in args {
                    self.expr(*arg, None);
                }
                Ty::Unknown
            }
        };
        let resolved = Resolved { targets, owner: Some(owner), law, self_ty, has_receiver, derefs: Vec::new() };
        self.typed.callees.insert(id, Callee::Resolved(resolved));
        output
    }

    /// A constructor's `Self` is what is expected of its result.
    fn unify_constructed(&mut self, owner: &MethodOwner, ty: &Ty, expected: &Ty) {
        let Some(function) = owner.function() else { return };
        if matches!(&self.index.function(function).function.output, TypeRef::Path(path) if path.ident() == Some("Self"))
        {
            self.variables.unify(ty, expected);
        }
    }

    /// A method declared by a trait, where the type is known: the type's own.
    fn specialise(&self, owner: MethodOwner, self_ty: &Ty, name: &str) -> MethodOwner {
        if let MethodOwner::Declared(of, _) = &owner
            && matches!(self_ty, Ty::Adt(..) | Ty::External(..))
            && let Some(own) = self.index.methods(self_ty, name).into_iter().find(|own| own.of_trait() == Some(of))
        {
            return own;
        }
        owner
    }

    fn law_of(&self, self_ty: &Ty, name: &str, owner: &MethodOwner) -> Option<usize> {
        let resolved = self.variables.resolve(self_ty);
        if let Some(spec) = self.index.filter_spec(&resolved) {
            return self.index.law_group(spec, name, owner);
        }
        // `SampledFilter::update(x)` with a type that is not known is still an update of `x`.
        owner.of_trait().filter(|of| self.index.is_filter_trait(of) && name == "update").map(|_| 0)
    }

    fn targets(&self, owner: &MethodOwner, name: &str) -> Vec<FunctionId> {
        match owner {
            MethodOwner::Inherent(id) | MethodOwner::Implemented(_, id) => vec![*id],
            MethodOwner::Declared(of, function) => {
                let mut targets = self.index.implementations(of, name);
                if targets.is_empty()
                    && let Some(function) = function
                    && self.index.function(*function).function.body.is_some()
                {
                    targets.push(*function);
                }
                targets
            }
        }
    }

    fn call_function(
        &mut self,
        id: ExprId,
        function: FunctionId,
        self_ty: Option<&Ty>,
        args: &[ExprId],
        expected: Option<&Ty>,
    ) -> Ty {
        let has_receiver = self.index.function(function).function.receiver.is_some();
        let output = self.instantiate(function, self_ty, args, has_receiver, expected);
        let owner = match self.index.function(function).owner {
            Owner::Module => None,
            Owner::Impl(_) => Some(MethodOwner::Inherent(function)),
            Owner::Trait(of) => Some(MethodOwner::Declared(TraitName::Local(of), Some(function))),
        };
        let resolved = Resolved {
            targets: vec![function],
            owner,
            law: None,
            self_ty: self_ty.cloned().unwrap_or(Ty::Unknown),
            has_receiver,
            derefs: Vec::new(),
        };
        self.typed.callees.insert(id, Callee::Resolved(resolved));
        output
    }

    /// Walks the arguments of a call of the function against its signature; answers what it gives back.
    fn instantiate(
        &mut self,
        function: FunctionId,
        self_ty: Option<&Ty>,
        args: &[ExprId],
        has_receiver: bool,
        expected: Option<&Ty>,
    ) -> Ty {
        let def = self.index.function(function);
        let scope = self.index.scope_of(function);
        let mut map: Vec<(String, Ty)> = Vec::new();
        match def.owner {
            Owner::Impl(id) => {
                let mut given = self_ty.map(|ty| self.index.impl_args(id, ty)).unwrap_or_default();
                for param in &self.index.impl_def(id).generics.params {
                    if !given.iter().any(|(name, _)| *name == param.name) && !param.is_const {
                        given.push((param.name.clone(), self.variables.fresh()));
                    }
                }
                map.extend(given);
            }
            Owner::Trait(_) => {
                if let Some(ty) = self_ty {
                    map.push(("Self".to_owned(), ty.clone()));
                }
            }
            Owner::Module => {}
        }
        for param in def.function.generics.params.iter().filter(|param| !param.is_const) {
            map.push((param.name.clone(), self.variables.fresh()));
        }
        let written = param_types(self.index, def, &scope);
        let output = self.index.lower(&def.function.output, &scope).substitute(&map);
        if let Some(expected) = expected {
            self.variables.unify(&output, expected);
        }
        let skip = usize::from(has_receiver && args.len() < written.len());
        // A closure knows its parameters only when the other arguments are known.
        for closures in [false, true] {
            for (number, arg) in args.iter().enumerate() {
                if matches!(self.body.expr(*arg).kind, ExprKind::Closure(_)) != closures {
                    continue;
                }
                let param = written.get(number + skip);
                self.argument(*arg, param, &map);
            }
        }
        output
    }

    fn argument(&mut self, arg: ExprId, param: Option<&Ty>, map: &[(String, Ty)]) {
        let body = self.body;
        let ExprKind::Closure(closure) = &body.expr(arg).kind else {
            let wanted = param.map(|ty| ty.substitute(map));
            let found = self.expr(arg, wanted.as_ref());
            if let Some(wanted) = wanted {
                self.coerce(&wanted, &found);
            }
            return;
        };
        let given = param
            .and_then(callable_bound)
            .map(|(params, _)| params.iter().map(|ty| ty.substitute(map)).collect::<Vec<_>>());
        let ty = self.closure(arg, closure, &given.unwrap_or_default());
        if let (Some((_, output)), Some(found)) =
            (param.and_then(callable_bound), self.closure_outputs.get(&arg).cloned())
        {
            self.variables.unify(&output.substitute(map), &found);
        }
        self.typed.expr_ty[arg.0 as usize] = ty;
    }

    /// Unifies an argument with a parameter; a reference to a pointer is a reference to its content where that is asked for.
    fn coerce(&mut self, wanted: &Ty, found: &Ty) {
        let found = self.variables.shallow(found);
        if let (Ty::Ref(_, inner), Ty::Ref(_, content)) = (self.variables.shallow(wanted), &found)
            && let Ty::External(path, args) = self.variables.shallow(content)
            && builtin::is_pointer(path.rsplit("::").next().unwrap_or(""))
            && !matches!(self.variables.shallow(&inner), Ty::Var(_) | Ty::External(..))
            && !args.is_empty()
        {
            return self.variables.unify(&inner, &args[0]);
        }
        self.variables.unify(wanted, &found);
    }

    fn call_external(&mut self, id: ExprId, path: &str, args: &[ExprId], expected: Option<&Ty>) -> Ty {
        let last = path.rsplit("::").next().unwrap_or("");
        let wrapper = match last {
            "Some" => Some("std::option::Option"),
            "Ok" | "Err" => Some("std::result::Result"),
            _ => None,
        };
        let inner_expected = match expected.map(|ty| self.variables.shallow(ty)) {
            Some(Ty::External(_, params)) if wrapper.is_some() => params.first().cloned(),
            _ => None,
        };
        let given: Vec<Ty> = args.iter().map(|arg| self.expr(*arg, inner_expected.as_ref())).collect();
        let first = given.first().cloned().unwrap_or(Ty::Unknown);
        if let Some(wrapper) = wrapper {
            self.typed.callees.insert(id, Callee::Constructor(Some(Def::External(path.to_owned()))));
            let other = self.variables.fresh();
            return match last {
                "Some" => Ty::std(wrapper, vec![first]),
                "Ok" => Ty::std(wrapper, vec![first, other]),
                _ => Ty::std(wrapper, vec![other, first]),
            };
        }
        // `Poll::Ready(x)`: a variant, because a function's name is lower case.
        let mut names = path.rsplit("::");
        let is_variant = names.next().is_some_and(|name| name.starts_with(char::is_uppercase))
            && names.next().is_some_and(|name| name.starts_with(char::is_uppercase));
        if is_variant {
            self.typed.callees.insert(id, Callee::Constructor(Some(Def::External(path.to_owned()))));
            let owner = path.rsplit_once("::").map_or(path, |(owner, _)| owner);
            return Ty::std(owner, vec![first]);
        }
        self.typed.callees.insert(id, Callee::External(path.to_owned()));
        match path {
            "std::default::Default::default" => expected.cloned().unwrap_or(Ty::Unknown),
            "std::mem::replace" | "std::mem::take" => first.peel().clone(),
            "std::array::from_fn" => {
                let item = self.closure_output(args.first().copied());
                Ty::Array(Box::new(item), crate::index::Length::default())
            }
            "std::iter::repeat_with" | "std::iter::from_fn" | "std::iter::repeat" => {
                builtin::iterator(self.closure_output(args.first().copied()))
            }
            "critical_section::with" | "cortex_m::interrupt::free" | "std::thread::scope" => {
                self.closure_output(args.first().copied())
            }
            _ => Ty::Unknown,
        }
    }

    fn closure_output(&self, arg: Option<ExprId>) -> Ty {
        arg.and_then(|arg| self.closure_outputs.get(&arg)).map_or(Ty::Unknown, |ty| self.variables.shallow(ty))
    }

    /// `Type::name(args)` of a type outside the analysed code.
    fn call_external_assoc(&mut self, id: ExprId, ty: Ty, name: &str, args: &[ExprId]) -> Ty {
        let given: Vec<Ty> = args.iter().map(|arg| self.expr(*arg, None)).collect();
        // `Type::default()` of a derive: the type is known although the function is not.
        let (path, params) = match &ty {
            Ty::External(path, params) => (path.clone(), params.clone()),
            _ => (self.index.type_name(&ty), Vec::new()),
        };
        self.typed.callees.insert(id, Callee::External(format!("{path}::{name}")));
        let last = path.rsplit("::").next().unwrap_or("");
        let makes_itself = matches!(name, "new" | "default" | "pin" | "const_new" | "init" | "create" | "builder")
            || name.starts_with("new_")
            || name.starts_with("with_")
            || name.starts_with("from");
        if !makes_itself {
            return Ty::Unknown;
        }
        let wraps =
            builtin::is_transparent(last) && matches!(name, "new" | "pin" | "from" | "const_new" | "new_cyclic");
        if wraps && let Some(first) = given.last() {
            let inner = match params.first() {
                Some(param) => {
                    self.variables.unify(param, first);
                    param.clone()
                }
                None => first.clone(),
            };
            return Ty::External(path, vec![inner]);
        }
        if path == "ceid_core::Cyclic" {
            return Ty::External(path, given);
        }
        if params.is_empty()
            && matches!(last, "Vec" | "VecDeque" | "HashMap" | "BTreeMap" | "Option" | "ArrayVec" | "IndexMap")
        {
            let count = if last.ends_with("Map") { 2 } else { 1 };
            return Ty::External(path, (0..count).map(|_| self.variables.fresh()).collect());
        }
        ty
    }

    pub(super) fn method_call(
        &mut self,
        id: ExprId,
        receiver: ExprId,
        method: &str,
        turbofish: &[TypeRef],
        args: &[ExprId],
    ) -> Ty {
        let start = self.expr(receiver, None);
        let mut ty = self.variables.shallow(&start);
        let mut derefs = Vec::new();
        for _ in 0..12 {
            match &ty {
                Ty::Ref(_, inner) => ty = self.variables.shallow(&inner.clone()),
                Ty::Pointer(_) => break,
                Ty::Adt(..) | Ty::Param(_) | Ty::Opaque(_) => {
                    let owners = self.index.methods(&ty, method);
                    if let Some(owner) = owners.into_iter().next() {
                        return self.resolved_method(id, owner, &ty, method, args, derefs);
                    }
                    match self.user_deref(&ty) {
                        Some((target, through)) => {
                            derefs.push(through);
                            ty = self.variables.shallow(&target);
                        }
                        None => break,
                    }
                }
                Ty::External(path, params) => {
                    let owners = self.index.methods(&ty, method);
                    if let Some(owner) = owners.into_iter().next() {
                        return self.resolved_method(id, owner, &ty, method, args, derefs);
                    }
                    if let Some(output) = self.builtin_call(id, &ty, method, args) {
                        return output;
                    }
                    if builtin::is_pointer(path.rsplit("::").next().unwrap_or("")) && !params.is_empty() {
                        ty = self.variables.shallow(&params[0].clone());
                    } else {
                        break;
                    }
                }
                Ty::Array(..) | Ty::Slice(_) => {
                    let owners = self.index.methods(&ty, method);
                    if let Some(owner) = owners.into_iter().next() {
                        return self.resolved_method(id, owner, &ty, method, args, derefs);
                    }
                    match self.builtin_call(id, &ty, method, args) {
                        Some(output) => return output,
                        None => break,
                    }
                }
                _ => break,
            }
        }
        self.unresolved_method(id, &ty, method, turbofish, args)
    }

    fn unresolved_method(&mut self, id: ExprId, ty: &Ty, method: &str, turbofish: &[TypeRef], args: &[ExprId]) -> Ty {
        for arg in args {
            self.expr(*arg, None);
        }
        if *ty == Ty::Bool && matches!(method, "then" | "then_some") {
            self.typed.callees.insert(id, Callee::Builtin);
            let made = match method {
                "then" => self.closure_output(args.first().copied()),
                _ => args.first().map_or(Ty::Unknown, |arg| self.typed.expr_ty[arg.0 as usize].clone()),
            };
            return Ty::std("std::option::Option", vec![made]);
        }
        let is_builtin = matches!(ty, Ty::Int | Ty::Float | Ty::Bool | Ty::Str | Ty::Char | Ty::Tuple(_));
        self.typed.callees.insert(id, if is_builtin { Callee::Builtin } else { Callee::Unknown });
        match (ty, method) {
            (_, "next_cycle") => Ty::std("std::option::Option", vec![Ty::std("ceid_core::Cycle", Vec::new())]),
            (_, "clone" | "to_owned") => ty.clone(),
            (Ty::Int | Ty::Float, _) if !method.starts_with("is_") => ty.clone(),
            (_, "parse" | "into" | "try_into") => {
                turbofish.first().map_or(Ty::Unknown, |ty| self.index.lower(ty, &self.scope))
            }
            _ => Ty::Unknown,
        }
    }

    fn builtin_call(&mut self, id: ExprId, receiver: &Ty, method: &str, args: &[ExprId]) -> Option<Ty> {
        let body = self.body;
        let receiver = self.shallow_deep(receiver);
        let mut given: Vec<Ty> = Vec::new();
        for arg in args {
            let is_closure = matches!(body.expr(*arg).kind, ExprKind::Closure(_));
            given.push(if is_closure { Ty::Unknown } else { self.expr(*arg, None) });
        }
        let mut closure_output = None;
        for arg in args {
            if let ExprKind::Closure(closure) = &body.expr(*arg).kind {
                let params = builtin::closure_params(&receiver, method, &given);
                let ty = self.closure(*arg, closure, &params);
                self.typed.expr_ty[arg.0 as usize] = ty;
                closure_output = self.closure_outputs.get(arg).map(|ty| self.variables.shallow(ty));
            }
        }
        let given: Vec<Ty> = given.iter().map(|ty| self.shallow_deep(ty)).collect();
        if closure_output.is_none()
            && let Some(Ty::FunctionItem(function)) = given.last()
        {
            let scope = self.index.scope_of(*function);
            closure_output = Some(self.index.lower(&self.index.function(*function).function.output, &scope));
        }
        let output = builtin::method(&receiver, method, &given, closure_output.as_ref())?;
        // A collection learns what it holds from what is put into it.
        if matches!(method, "push" | "push_back" | "insert" | "get_or_insert_with" | "or_insert" | "replace" | "set")
            && let Ty::External(_, params) = &receiver
        {
            for (param, found) in params.iter().rev().zip(given.iter().rev()) {
                self.variables.unify(param, found);
            }
        }
        self.typed.callees.insert(id, Callee::Builtin);
        Some(output)
    }

    fn resolved_method(
        &mut self,
        id: ExprId,
        owner: MethodOwner,
        ty: &Ty,
        method: &str,
        args: &[ExprId],
        derefs: Vec<FunctionId>,
    ) -> Ty {
        let law = self.law_of(ty, method, &owner);
        let targets = self.targets(&owner, method);
        let output = match owner.function() {
            Some(function) => self.instantiate(function, Some(ty), args, true, None),
            None => {
                for arg in args {
                    self.expr(*arg, None);
                }
                Ty::Unknown
            }
        };
        let resolved = Resolved { targets, owner: Some(owner), law, self_ty: ty.clone(), has_receiver: true, derefs };
        self.typed.callees.insert(id, Callee::Resolved(resolved));
        output
    }

    /// The type behind references and pointers.
    pub(super) fn behind_pointers(&self, ty: &Ty) -> Ty {
        let mut ty = self.variables.shallow(ty);
        for _ in 0..8 {
            match &ty {
                Ty::Ref(_, inner) => ty = self.variables.shallow(&inner.clone()),
                Ty::External(path, args)
                    if builtin::is_pointer(path.rsplit("::").next().unwrap_or("")) && !args.is_empty() =>
                {
                    ty = self.variables.shallow(&args[0].clone());
                }
                _ => break,
            }
        }
        ty
    }
}

/// The parameters and the output of a type that can only be called: `impl FnMut(A) -> B`, `F: Fn(A)`, `&mut dyn FnMut(A)`.
fn callable_bound(ty: &Ty) -> Option<(Vec<Ty>, Ty)> {
    let bounds: &[TraitRef] = match ty.peel() {
        Ty::Param(param) => {
            let ParamTy { bounds, .. } = &**param;
            bounds
        }
        Ty::Opaque(bounds) => bounds,
        Ty::External(path, args) if path.ends_with("::Box") && !args.is_empty() => return callable_bound(&args[0]),
        _ => return None,
    };
    bounds.iter().find_map(|bound| {
        let TraitName::External(path) = &bound.name else { return None };
        if !matches!(
            path.rsplit("::").next(),
            Some("Fn" | "FnMut" | "FnOnce" | "AsyncFn" | "AsyncFnMut" | "AsyncFnOnce")
        ) {
            return None;
        }
        let params = match bound.args.first() {
            Some(Ty::Tuple(params)) => params.clone(),
            _ => Vec::new(),
        };
        let output = bound.assoc.iter().find(|(name, _)| name == "Output").map_or(Ty::unit(), |(_, ty)| ty.clone());
        Some((params, output))
    })
}
