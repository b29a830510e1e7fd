//! Calls: which function or method is meant, and what it gives back.

use super::builtin;
use super::infer::{Infer, param_types};
use super::named::{may_be_none, may_fail};
use super::paths::Value;
use super::{Callee, Resolved};
use crate::index::{Def, FunctionId, MethodOwner, Owner, Ty};
use crate::syntax::tree::{ExprId, ExprKind, Path};

impl Infer<'_> {
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
                if let Some(params) = self.typed.closure_params.get(&closure).cloned() {
                    for (param, given) in params.iter().zip(&given) {
                        self.variables.unify(param, given);
                    }
                }
                self.typed.callees.insert(id, Callee::Closure(closure));
                self.closure_outputs.get(&closure).cloned().unwrap_or(Ty::Unknown)
            }
            Ty::FunctionItem(function) => self.call_function(id, function, args, Vec::new(), None),
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
                // `make()()`: what a call gives says what it gives when it is called.
                ty.called_as().map_or(Ty::Unknown, |(_, output)| output)
            }
        }
    }

    fn call_value(&mut self, id: ExprId, value: Value, path: &Path, args: &[ExprId], expected: Option<&Ty>) -> Ty {
        match value {
            Value::Local(local) => {
                let ty = self.variables.shallow(&self.typed.locals[local.0 as usize].ty.clone()).peel().clone();
                match ty.called_as() {
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
            Value::Def(Def::Function(function)) => {
                let written = self.written_types(function, path);
                self.call_function(id, function, args, written, expected)
            }
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
            Value::Def(Def::External(external)) => {
                let made = self.call_external(id, &external, args, expected);
                self.read_as_written(made, path)
            }
            Value::Assoc(_, Some(ty)) | Value::ExternalAssoc(ty, _) if self.is_adapted(&ty) => {
                self.adapted(id, path.last(), args)
            }
            Value::Assoc(owners, ty) => {
                let Some(owner) = owners.into_iter().next() else { return Ty::Unknown };
                self.call_assoc(id, owner, ty, path.last(), args, expected)
            }
            Value::ExternalAssoc(ty, name) => self.call_external_assoc(id, ty, &name, args, expected),
            Value::Def(_) | Value::Unknown => {
                for arg in args {
                    self.expr(*arg, None);
                }
                self.typed.callees.insert(id, Callee::Unknown);
                self.read_as_written(Ty::Unknown, path)
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
            let named = ty.clone().filter(|ty| !matches!(ty, Ty::Var(_)));
            // A path may leave out the arguments that the receiver has.
            if let (Some(named @ Ty::Adt(own, _)), Ty::Adt(other, _)) = (&named, &found)
                && own == other
            {
                self.variables.unify(named, &found);
            }
            named.unwrap_or(found)
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
        let output = match owner.function() {
            Some(function) => self.instantiate(function, Some(&self_ty), args, has_receiver, (Vec::new(), expected)),
            None => {
                for arg in args {
                    self.expr(*arg, None);
                }
                Ty::Unknown
            }
        };
        let given = if has_receiver { args.get(1..).unwrap_or_default() } else { args };
        let targets = self.bodies(&owner, &self_ty, name, given);
        let resolved = Resolved { targets, owner: Some(owner), law, self_ty, has_receiver, derefs: Vec::new() };
        self.typed.callees.insert(id, Callee::Resolved(resolved));
        output
    }

    /// A method declared by a trait, where the type is known: the type's own.
    fn specialise(&self, owner: MethodOwner, self_ty: &Ty, name: &str) -> MethodOwner {
        if let MethodOwner::Declared(of, _) = &owner
            && matches!(self_ty, Ty::Adt(..) | Ty::External(..))
            && let Some(own) = self.methods_of(self_ty, name).into_iter().find(|own| own.of_trait() == Some(of))
        {
            return own;
        }
        owner
    }

    pub(super) fn law_of(&self, self_ty: &Ty, name: &str, owner: &MethodOwner) -> Option<usize> {
        let resolved = self.variables.resolve(self_ty);
        if let Some(spec) = self.index.law_spec(&resolved) {
            return self.index.law_group(spec, name, owner);
        }
        // `SampledFilter::update(x)` with a type that is not known is still an update of `x`.
        owner.of_trait().filter(|of| self.index.is_filter_trait(of) && name == "update").map(|_| 0)
    }

    /// Walks the arguments of a call of the function against its signature; answers what it gives back.
    pub(super) fn instantiate(
        &mut self,
        function: FunctionId,
        self_ty: Option<&Ty>,
        args: &[ExprId],
        has_receiver: bool,
        (written_types, expected): (Vec<Ty>, Option<&Ty>),
    ) -> Ty {
        let def = self.index.function(function);
        let mut scope = self.index.scope_of(function);
        let mut map: Vec<(String, Ty)> = Vec::new();
        // What a trait calls `Self::Item` is what the type at hand says.
        if let (Owner::Trait(_), Some(ty @ (Ty::Adt(..) | Ty::Param(_) | Ty::Opaque(_)))) = (&def.owner, self_ty) {
            scope.self_ty = Some(ty.clone());
        }
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
        let mut written_types = written_types.into_iter();
        for param in def.function.generics.params.iter().filter(|param| !param.is_const) {
            let ty = written_types.next().unwrap_or_else(|| self.variables.fresh());
            map.push((param.name.clone(), ty));
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
            if let Some((params, output)) = param.and_then(Ty::called_as) {
                let given = params.first().map(|given| given.substitute(map));
                if let Some(made) = self.output_of_named(arg, &found, given.as_ref()) {
                    self.variables.unify(&output.substitute(map), &made);
                }
            }
            return;
        };
        let given = param
            .and_then(Ty::called_as)
            .map(|(params, _)| params.iter().map(|ty| ty.substitute(map)).collect::<Vec<_>>());
        let ty = self.closure(arg, closure, &given.unwrap_or_default());
        if let (Some((_, output)), Some(found)) =
            (param.and_then(Ty::called_as), self.closure_outputs.get(&arg).cloned())
        {
            self.variables.unify(&output.substitute(map), &found);
        }
        self.typed.expr_ty[arg.0 as usize] = ty;
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
        if let Some(made) = self.index.made_by(path) {
            return made;
        }
        match path {
            "std::default::Default::default" => expected.cloned().unwrap_or(Ty::Unknown),
            "std::mem::replace" | "std::mem::take" => self.variables.shallow(&first).peel().clone(),
            "std::slice::from_mut" => Ty::Ref(true, Box::new(Ty::Slice(Box::new(first.peel().clone())))),
            "std::array::from_fn" => {
                let item = self.closure_output(args.first().copied());
                let length = match expected.map(|ty| self.variables.shallow(ty)) {
                    Some(Ty::Array(_, length)) => length,
                    _ => crate::index::Length::default(),
                };
                Ty::Array(Box::new(item), length)
            }
            "std::iter::repeat_with" | "std::iter::from_fn" => {
                builtin::iterator(self.made_by_function(args.first().copied(), &first))
            }
            "std::iter::once" | "std::iter::repeat" | "std::iter::repeat_n" => builtin::iterator(first),
            "std::iter::zip" => builtin::iterator(Ty::Tuple(given.iter().map(|ty| self.item_ty(ty)).collect())),
            "critical_section::with" | "cortex_m::interrupt::free" | "std::thread::scope" => {
                self.closure_output(args.first().copied())
            }
            "std::io::stdin" => Ty::std("std::io::Stdin", Vec::new()),
            "std::sync::mpsc::channel" | "std::sync::mpsc::sync_channel" => {
                let message = self.variables.fresh();
                let end = |name: &str| Ty::std(&format!("std::sync::mpsc::{name}"), vec![message.clone()]);
                Ty::Tuple(vec![end(if last == "channel" { "Sender" } else { "SyncSender" }), end("Receiver")])
            }
            _ => Ty::Unknown,
        }
    }

    /// What a function that is handed over gives, a closure or one that is named.
    fn made_by_function(&mut self, function: Option<ExprId>, found: &Ty) -> Ty {
        let made = self.closure_output(function);
        let named = function.and_then(|function| self.output_of_named(function, found, None));
        if made == Ty::Unknown { named.unwrap_or(made) } else { made }
    }

    pub(super) fn closure_output(&self, arg: Option<ExprId>) -> Ty {
        arg.and_then(|arg| self.closure_outputs.get(&arg)).map_or(Ty::Unknown, |ty| self.variables.shallow(ty))
    }

    /// `Type::name(args)` of a type outside the analysed code.
    fn call_external_assoc(&mut self, id: ExprId, ty: Ty, name: &str, args: &[ExprId], expected: Option<&Ty>) -> Ty {
        if let Some(spec) = self.index.law_spec(&ty)
            && matches!(ty, Ty::External(..))
        {
            let law = spec.group(name);
            let resets = spec.resets.iter().chain(&spec.partial_resets).any(|reset| reset == name);
            if law.is_some() || resets {
                return self.external_filter_method(id, &ty, law, args, Vec::new());
            }
        }
        if let Some(made) = self.path_method(id, &ty, name, args) {
            return made;
        }
        let given: Vec<Ty> = args.iter().map(|arg| self.wrapped(*arg, expected)).collect();
        // `Type::default()` of a derive: the type is known although the function is not.
        let (path, params) = match &ty {
            Ty::External(path, params) => (path.clone(), params.clone()),
            _ => (self.index.type_name(&ty), Vec::new()),
        };
        self.typed.callees.insert(id, Callee::External(format!("{path}::{name}")));
        if let Some(made) = self.index.made_by(&format!("{path}::{name}")) {
            return made;
        }
        let last = builtin::family(path.rsplit("::").next().unwrap_or(""));
        if let ("Rc" | "Arc", Some(of)) = (path.rsplit("::").next().unwrap_or(""), given.first()) {
            let of = self.variables.resolve(of);
            if let Some(made) = builtin::handle_function(of.peel(), name) {
                return made;
            }
        }
        if name == "clone" {
            return given.first().map_or(Ty::Unknown, |first| first.peel().clone());
        }
        // What is lent exclusively may be reached as a cell meanwhile.
        if let ("Cell", "from_mut", [lent]) = (last, name, given.as_slice()) {
            let content = self.variables.resolve(lent).peel().clone();
            return Ty::Ref(false, Box::new(Ty::External(path, vec![content])));
        }
        let makes_itself = (name == "register" && matches!(ty, Ty::Adt(id, _) if self.index.is_filter_set(id)))
            || names_constructor(name);
        // `File::open(…)?` and its kin: the function is known although its crate is not read.
        if may_fail(&path, name) {
            return Ty::std("std::result::Result", vec![ty, Ty::Unknown]);
        }
        if may_be_none(&path, name) {
            return Ty::std("std::option::Option", vec![ty]);
        }
        if let Some(made) = self.made_by_unread(&ty, name) {
            return made;
        }
        let is_guard = self.index.guard_spec(&ty).is_some_and(|spec| spec.register == name);
        if !makes_itself && !is_guard {
            return Ty::Unknown;
        }
        let wraps =
            builtin::is_transparent(last) && matches!(name, "new" | "pin" | "from" | "const_new" | "new_cyclic");
        if wraps && let Some(first) = given.last() {
            // What is made on demand is what the function gives.
            let is_lazy = matches!(last, "LazyLock" | "LazyCell" | "Lazy");
            let made = is_lazy.then(|| self.made_by_function(args.last().copied(), first));
            let first = made.as_ref().unwrap_or(first);
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
            && matches!(
                last,
                "Vec"
                    | "VecDeque"
                    | "HashMap"
                    | "BTreeMap"
                    | "Option"
                    | "ArrayVec"
                    | "IndexMap"
                    | "OnceCell"
                    | "OnceLock"
            )
        {
            let count = if last.ends_with("Map") { 2 } else { 1 };
            let made: Vec<Ty> = (0..count).map(|_| self.variables.fresh()).collect();
            // `Vec::from([a, b])`, `BTreeMap::from([(key, value)])`
            let from = given.first().filter(|_| name == "from" && last != "Option");
            let from = from.map(|from| self.variables.resolve(from));
            match (from.as_ref().and_then(|from| from.peel().element()), made.as_slice()) {
                (Some(item), [own]) => self.variables.unify(own, item),
                (Some(Ty::Tuple(pair)), [key, value]) if pair.len() == 2 => {
                    self.variables.unify(key, &pair[0]);
                    self.variables.unify(value, &pair[1]);
                }
                _ => {}
            }
            return Ty::External(path, made);
        }
        ty
    }
}

/// Whether an associated function of that name gives its type, as far as a name tells.
#[must_use]
pub fn names_constructor(name: &str) -> bool {
    matches!(name, "new" | "default" | "pin" | "const_new" | "init" | "create" | "builder" | "now")
        || ["new_", "with_", "from"].iter().any(|prefix| name.starts_with(prefix))
}
