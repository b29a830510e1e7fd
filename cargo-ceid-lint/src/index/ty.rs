//! Types with their names resolved, and how a written type becomes one. Infers nothing.

use std::sync::Arc;

use super::names::segments;
use super::{Def, FunctionId, ImplId, Index, ModuleId, Namespace, Owner, TraitId, TypeId, ValueId};
use crate::syntax::tree::{Bound, ConstText, GenericArg, Generics, Path, Segment, TypeRef};

/// A type.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Ty {
    /// Cannot be known.
    Unknown,
    /// Not known yet: a variable of the inference.
    Var(u32),
    /// A struct, union or enum of the analysed code, with its arguments.
    Adt(TypeId, Vec<Ty>),
    /// A type of a crate whose sources are not read, by its path.
    External(String, Vec<Ty>),
    /// `&T`, `&mut T`
    Ref(bool, Box<Ty>),
    /// A raw pointer.
    Pointer(Box<Ty>),
    /// A tuple.
    Tuple(Vec<Ty>),
    /// An array.
    Array(Box<Ty>, Length),
    /// A slice.
    Slice(Box<Ty>),
    /// A generic parameter with its bounds.
    Param(Arc<ParamTy>),
    /// `impl Trait`, `dyn Trait`, or an associated type of which only the bounds are known.
    Opaque(Arc<Vec<TraitRef>>),
    /// `fn(A) -> B`
    Function(Vec<Ty>, Box<Ty>),
    /// A function by its name.
    FunctionItem(FunctionId),
    /// A closure of the same body, by the number of its expression.
    Closure(u32),
    /// An integer.
    Int,
    /// A float.
    Float,
    /// A truth value.
    Bool,
    /// `str`
    Str,
    /// A character.
    Char,
    /// `!`
    Never,
}

/// The length of an array.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
pub struct Length {
    /// The value, if it is known.
    pub value: Option<u64>,
    /// What tells it from others of which no value is known either: what its name means, or its spelling.
    pub text: String,
}

/// A generic parameter.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ParamTy {
    /// Its name.
    pub name: String,
    /// Its bounds.
    pub bounds: Vec<TraitRef>,
}

/// A trait by its name.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum TraitName {
    /// Of the analysed code.
    Local(TraitId),
    /// Of a crate whose sources are not read, by its path.
    External(String),
}

/// A bound.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct TraitRef {
    /// The trait.
    pub name: TraitName,
    /// Its type arguments.
    pub args: Vec<Ty>,
    /// Its associated types as far as the bound names them.
    pub assoc: Vec<(String, Ty)>,
}

impl Ty {
    /// The unit type.
    #[must_use]
    pub fn unit() -> Self {
        Self::Tuple(Vec::new())
    }

    /// A type of the standard library with one argument.
    #[must_use]
    pub fn std(path: &str, args: Vec<Self>) -> Self {
        Self::External(path.to_owned(), args)
    }

    /// The type behind all references.
    #[must_use]
    pub fn peel(&self) -> &Self {
        let mut ty = self;
        while let Self::Ref(_, inner) = ty {
            ty = inner;
        }
        ty
    }

    /// What lies in an array, a slice or a vector.
    #[must_use]
    pub fn element(&self) -> Option<&Self> {
        match self {
            Self::Array(inner, _) | Self::Slice(inner) => Some(inner),
            Self::External(path, args) if path == "std::vec::Vec" => args.first(),
            _ => None,
        }
    }

    /// The last name of a type outside the analysed code.
    #[must_use]
    pub fn external_name(&self) -> Option<&str> {
        match self {
            Self::External(path, _) => path.rsplit("::").next(),
            _ => None,
        }
    }

    /// What a parameter or `impl Trait` gives in each round, if its bounds say that it is an iterator or can become one.
    #[must_use]
    pub fn items(&self) -> Option<&Self> {
        let bounds = match self {
            Self::Param(param) => &param.bounds,
            Self::Opaque(bounds) => bounds.as_ref(),
            _ => return None,
        };
        let iterates = |bound: &&TraitRef| matches!(&bound.name, TraitName::External(path) if path.starts_with("std::iter::") && path.ends_with("Iterator"));
        let mut named = bounds.iter().filter(iterates).flat_map(|bound| &bound.assoc);
        named.find(|(name, _)| name == "Item").map(|(_, item)| item)
    }

    /// Whether the type or one of the types that it is made of is such a one.
    pub fn has_part(&self, is_such: &mut dyn FnMut(&Self) -> bool) -> bool {
        let parts: &[Self] = match self {
            Self::Adt(_, args) | Self::External(_, args) | Self::Tuple(args) => args,
            Self::Ref(_, inner) | Self::Pointer(inner) | Self::Array(inner, _) | Self::Slice(inner) => {
                std::slice::from_ref(&**inner)
            }
            _ => &[],
        };
        is_such(self) || parts.iter().any(|part| part.has_part(is_such))
    }

    /// Whether it is a pointer that several own: a clone of it leads to the same value.
    #[must_use]
    pub fn is_shared_pointer(&self) -> bool {
        matches!(self.external_name(), Some("Rc" | "Arc" | "Weak"))
    }

    /// Whether a value of the type is called by its name, whatever stands behind that.
    #[must_use]
    pub fn is_callable(&self) -> bool {
        matches!(self, Self::Closure(_)) || self.called_as().is_some()
    }

    /// The parameters and the output of a type that can only be called: `impl FnMut(A) -> B`, `F: Fn(A)`, `&mut dyn FnMut(A)`.
    #[must_use]
    pub fn called_as(&self) -> Option<(Vec<Self>, Self)> {
        let bounds: &[TraitRef] = match self.peel() {
            Self::Param(param) => &param.bounds,
            Self::Opaque(bounds) => bounds,
            Self::External(path, args) if matches!(path.rsplit("::").next(), Some("Box" | "Rc" | "Arc")) => {
                return args.first()?.called_as();
            }
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
                Some(Self::Tuple(params)) => params.clone(),
                _ => Vec::new(),
            };
            let output = bound.assoc.iter().find(|(name, _)| name == "Output");
            Some((params, output.map_or(Self::unit(), |(_, ty)| ty.clone())))
        })
    }

    /// The same type with parameters replaced by name.
    #[must_use]
    pub fn substitute(&self, map: &[(String, Self)]) -> Self {
        if map.is_empty() {
            return self.clone();
        }
        let all = |types: &[Self]| types.iter().map(|ty| ty.substitute(map)).collect::<Vec<_>>();
        match self {
            Self::Param(param) => {
                map.iter().find(|(name, _)| *name == param.name).map_or_else(|| self.clone(), |(_, ty)| ty.clone())
            }
            Self::Adt(id, args) => Self::Adt(*id, all(args)),
            Self::External(path, args) => Self::External(path.clone(), all(args)),
            Self::Ref(mutable, inner) => Self::Ref(*mutable, Box::new(inner.substitute(map))),
            Self::Pointer(inner) => Self::Pointer(Box::new(inner.substitute(map))),
            Self::Tuple(types) => Self::Tuple(all(types)),
            Self::Array(inner, length) => Self::Array(Box::new(inner.substitute(map)), length.clone()),
            Self::Slice(inner) => Self::Slice(Box::new(inner.substitute(map))),
            Self::Function(params, output) => Self::Function(all(params), Box::new(output.substitute(map))),
            Self::Opaque(bounds) => {
                let replaced = bounds.iter().map(|bound| TraitRef {
                    name: bound.name.clone(),
                    args: all(&bound.args),
                    assoc: bound.assoc.iter().map(|(name, ty)| (name.clone(), ty.substitute(map))).collect(),
                });
                Self::Opaque(Arc::new(replaced.collect()))
            }
            Self::Unknown
            | Self::Var(_)
            | Self::FunctionItem(_)
            | Self::Closure(_)
            | Self::Int
            | Self::Float
            | Self::Bool
            | Self::Str
            | Self::Char
            | Self::Never => self.clone(),
        }
    }
}

/// Where a written type is read.
#[derive(Clone, Debug)]
pub struct TyScope<'a> {
    /// The module.
    pub module: ModuleId,
    /// What `Self` means.
    pub self_ty: Option<Ty>,
    /// The trait in whose declaration it stands.
    pub self_trait: Option<TraitId>,
    /// The impl in which it stands.
    pub self_impl: Option<ImplId>,
    /// The function in which it stands.
    pub function: Option<FunctionId>,
    /// The parameters in scope, innermost first.
    pub generics: Vec<&'a Generics>,
    /// What some of them stand for, so that their associated types are known.
    pub args: Vec<(String, Ty)>,
}

impl TyScope<'_> {
    /// Whether a name is that of a constant which the code around is generic over.
    #[must_use]
    pub fn declares_length(&self, name: &str) -> bool {
        self.declaring(name).is_some()
    }

    /// Which of the generics declare a constant of this name.
    fn declaring(&self, name: &str) -> Option<usize> {
        let declares = |generics: &&Generics| generics.params.iter().any(|param| param.is_const && param.name == name);
        self.generics.iter().position(declares)
    }
}

/// How deep types are followed: more is a cycle of aliases.
const MAX_DEPTH: u32 = 24;

impl Index {
    /// The scope of a function's, constant's or type's signature.
    #[must_use]
    pub fn scope<'a>(&'a self, module: ModuleId, owner: Owner, generics: Option<&'a Generics>) -> TyScope<'a> {
        let mut all: Vec<&Generics> = generics.into_iter().collect();
        let mut scope = TyScope {
            module,
            self_ty: None,
            self_trait: None,
            self_impl: None,
            function: None,
            generics: Vec::new(),
            args: Vec::new(),
        };
        match owner {
            Owner::Module => {}
            Owner::Impl(id) => {
                let def = self.impl_def(id);
                all.push(&def.generics);
                scope.self_ty = Some(def.self_ty.clone());
                scope.self_impl = Some(id);
            }
            Owner::Trait(id) => {
                let def = self.trait_def(id);
                all.push(&def.generics);
                let own = TraitRef { name: TraitName::Local(id), args: Vec::new(), assoc: Vec::new() };
                scope.self_ty = Some(Ty::Param(Arc::new(ParamTy { name: "Self".to_owned(), bounds: vec![own] })));
                scope.self_trait = Some(id);
            }
        }
        scope.generics = all;
        scope
    }

    /// The written type with its names resolved.
    #[must_use]
    pub fn lower(&self, ty: &TypeRef, scope: &TyScope<'_>) -> Ty {
        self.lower_at(ty, scope, 0)
    }

    fn lower_at(&self, ty: &TypeRef, scope: &TyScope<'_>, depth: u32) -> Ty {
        if depth > MAX_DEPTH {
            return Ty::Unknown;
        }
        let go = |inner: &TypeRef| self.lower_at(inner, scope, depth + 1);
        match ty {
            TypeRef::Path(path) => self.lower_path(path, scope, depth + 1),
            TypeRef::Reference { mutable, inner } => Ty::Ref(*mutable, Box::new(go(inner))),
            TypeRef::Pointer(inner) => Ty::Pointer(Box::new(go(inner))),
            TypeRef::Tuple(types) => Ty::Tuple(types.iter().map(go).collect()),
            TypeRef::Array(inner, length) => Ty::Array(Box::new(go(inner)), self.length(length, scope)),
            TypeRef::Slice(inner) => Ty::Slice(Box::new(go(inner))),
            TypeRef::ImplTrait(bounds) | TypeRef::DynTrait(bounds) => {
                let bounds = self.lower_bounds(bounds, scope, depth + 1);
                self.shared_resource(&bounds).unwrap_or_else(|| Ty::Opaque(Arc::new(bounds)))
            }
            TypeRef::FnPointer(params, output) => Ty::Function(params.iter().map(go).collect(), Box::new(go(output))),
            TypeRef::Never => Ty::Never,
            TypeRef::Infer | TypeRef::Unknown => Ty::Unknown,
        }
    }

    /// The length of an array: a literal, a constant of the analysed code that is one, or what comes out of such.
    #[must_use]
    pub fn length(&self, length: &ConstText, scope: &TyScope<'_>) -> Length {
        let text = &length.text;
        if length.value.is_some() {
            return Length { value: length.value, text: text.clone() };
        }
        if let Some((operator, left, right)) = length.sides.as_deref() {
            let [left, right] = [left, right].map(|side| self.length(side, scope));
            let value = left.value.zip(right.value).and_then(|(left, right)| arithmetic(operator, left, right));
            return Length { value, text: format!("({}{operator}{})", left.text, right.text) };
        }
        if let Some(at) = scope.declaring(text) {
            // What a function is called with need not be what a type has under the same name.
            let own = scope.function.filter(|_| at == 0);
            return Length { value: None, text: own.map_or_else(|| text.clone(), |id| format!("{text} of {id:?}")) };
        }
        let names: Vec<String> = text.split("::").map(str::to_owned).collect();
        let text = match self.resolve(scope.module, &names, Namespace::Value) {
            Some(Def::Value(id)) => format!("{id:?}"),
            _ => text.clone(),
        };
        Length { value: self.const_value(scope, &names), text }
    }

    /// The value of an integer constant of the analysed code.
    #[must_use]
    pub fn const_value(&self, scope: &TyScope<'_>, names: &[String]) -> Option<u64> {
        self.const_value_at(scope, names, 0)
    }

    fn const_value_at(&self, scope: &TyScope<'_>, names: &[String], depth: u32) -> Option<u64> {
        let value = if let [owner, name] = names
            && owner == "Self"
        {
            *self.impl_def(scope.self_impl?).consts.get(name)?
        } else {
            match self.resolve(scope.module, names, Namespace::Value)? {
                Def::Value(id) => id,
                _ => return None,
            }
        };
        self.const_number_at(value, depth)
    }

    /// The number that a constant is, whatever it is called where it is used.
    #[must_use]
    pub fn const_number(&self, id: ValueId) -> Option<u64> {
        self.const_number_at(id, 0)
    }

    /// The truth value of a constant whose value is a literal.
    #[must_use]
    pub fn const_truth(&self, id: ValueId) -> Option<bool> {
        use crate::syntax::tree::{ExprKind, Literal};
        let item = &self.value(id).item;
        let body = item.value.as_ref().filter(|_| !item.is_static)?;
        match &body.expr(body.root).kind {
            ExprKind::Literal(Literal::Bool(value)) => Some(*value),
            ExprKind::Macro(call) => call.kind.built(),
            _ => None,
        }
    }

    /// The truth value of an associated constant of a type.
    #[must_use]
    pub fn truth_of(&self, ty: &Ty, name: &str) -> Option<bool> {
        let found: Vec<ValueId> =
            self.impls_of(ty).into_iter().filter_map(|id| self.impl_def(id).consts.get(name).copied()).collect();
        if let [id] = found.as_slice() { self.const_truth(*id) } else { None }
    }

    fn const_number_at(&self, id: ValueId, depth: u32) -> Option<u64> {
        let def = self.value(id);
        let body = def.item.value.as_ref()?;
        let scope = self.scope(def.module, def.owner, None);
        self.const_expr(&scope, body, body.root, depth + 1)
    }

    /// The value of a constant expression of literals, constants and arithmetic.
    fn const_expr(
        &self,
        scope: &TyScope<'_>,
        body: &crate::syntax::tree::Body,
        id: crate::syntax::tree::ExprId,
        depth: u32,
    ) -> Option<u64> {
        use crate::syntax::tree::{ExprKind, Literal};
        if depth > MAX_DEPTH {
            return None;
        }
        match &body.expr(id).kind {
            ExprKind::Literal(Literal::Int(value, _)) => *value,
            ExprKind::Cast { value, .. } => self.const_expr(scope, body, *value, depth + 1),
            ExprKind::Block(block) if block.stmts.is_empty() => self.const_expr(scope, body, block.tail?, depth + 1),
            ExprKind::Path(path) => {
                let names: Vec<String> = path.segments.iter().map(|segment| segment.name.clone()).collect();
                self.const_value_at(scope, &names, depth + 1)
            }
            ExprKind::If { condition, then, otherwise } => {
                let ExprKind::Macro(asked) = &body.expr(*condition).kind else { return None };
                let taken = if asked.kind.built()? { Some(*then) } else { *otherwise };
                self.const_expr(scope, body, taken?, depth + 1)
            }
            ExprKind::Binary { op, lhs, rhs } => {
                let left = self.const_expr(scope, body, *lhs, depth + 1)?;
                let right = self.const_expr(scope, body, *rhs, depth + 1)?;
                arithmetic(op, left, right)
            }
            _ => None,
        }
    }

    pub(super) fn lower_bounds(&self, bounds: &[Bound], scope: &TyScope<'_>, depth: u32) -> Vec<TraitRef> {
        bounds.iter().filter_map(|bound| self.lower_bound(bound, scope, depth)).collect()
    }

    fn lower_bound(&self, bound: &Bound, scope: &TyScope<'_>, depth: u32) -> Option<TraitRef> {
        let name = self.trait_name(scope.module, bound)?;
        let mut args = Vec::new();
        let mut assoc = Vec::new();
        for arg in &bound.segments.last()?.args {
            match arg {
                GenericArg::Type(ty) => args.push(self.lower_at(ty, scope, depth + 1)),
                GenericArg::Assoc(name, ty) => assoc.push((name.clone(), self.lower_at(ty, scope, depth + 1))),
                GenericArg::Const(_) | GenericArg::Constraint(..) => {}
            }
        }
        Some(TraitRef { name, args, assoc })
    }

    /// The trait that a path names.
    #[must_use]
    pub fn trait_name(&self, module: ModuleId, path: &Path) -> Option<TraitName> {
        match self.resolve(module, &segments(path), Namespace::Type) {
            Some(Def::Trait(id)) => Some(TraitName::Local(id)),
            Some(Def::External(path)) => Some(TraitName::External(path)),
            Some(_) => None,
            None => Some(TraitName::External(path.text())),
        }
    }

    fn lower_path(&self, path: &Path, scope: &TyScope<'_>, depth: u32) -> Ty {
        let found = self.lower_path_in(path, scope, depth);
        if found != Ty::Unknown || scope.args.is_empty() {
            return found;
        }
        // An associated type of what is not known yet has the bounds that its trait asks for.
        self.lower_path_in(path, &TyScope { args: Vec::new(), ..scope.clone() }, depth)
    }

    fn lower_path_in(&self, path: &Path, scope: &TyScope<'_>, depth: u32) -> Ty {
        if depth > MAX_DEPTH {
            return Ty::Unknown;
        }
        if let Some(self_ty) = &path.self_ty {
            let base = self.lower_at(self_ty, scope, depth + 1);
            let of = Path { segments: path.segments[..path.trait_segments].to_vec(), ..Path::default() };
            let of = if of.segments.is_empty() { None } else { self.trait_name(scope.module, &of) };
            return self.project_at(&base, of.as_ref(), path.last(), depth + 1);
        }
        let [first, rest @ ..] = path.segments.as_slice() else { return Ty::Unknown };
        if !path.global {
            let base = match first.name.as_str() {
                "Self" => scope.self_ty.clone(),
                name => self.generic_param(name, scope, depth),
            };
            if let Some(base) = base {
                return match rest {
                    [] => base,
                    [assoc] => self.project_in(&base, &assoc.name, scope, depth),
                    _ => Ty::Unknown,
                };
            }
            if rest.is_empty()
                && let Some(primitive) = primitive(&first.name)
            {
                return primitive;
            }
        }
        let args = self.lower_args(path.segments.last(), scope, depth);
        match self.resolve(scope.module, &segments(path), Namespace::Type) {
            Some(Def::Type(id)) => Ty::Adt(id, self.complete_args(id, args)),
            Some(Def::Alias(id)) => {
                let alias = &self.aliases[id.0 as usize];
                let inner = TyScope {
                    module: alias.module,
                    self_ty: None,
                    self_trait: None,
                    self_impl: None,
                    function: None,
                    generics: vec![&alias.generics],
                    args: Vec::new(),
                };
                let target = self.lower_at(&alias.ty, &inner, depth + 1);
                // What is not written is inferred: `Short::new(filter)`.
                let given = |at: usize| args.get(at).cloned().unwrap_or(Ty::Unknown);
                let params = alias.generics.params.iter().enumerate();
                let named: Vec<(String, Ty)> = params.map(|(at, param)| (param.name.clone(), given(at))).collect();
                target.substitute(&named)
            }
            Some(Def::Trait(id)) => {
                Ty::Opaque(Arc::new(vec![TraitRef { name: TraitName::Local(id), args, assoc: Vec::new() }]))
            }
            Some(Def::External(path)) => iterator_of(&path, &args).unwrap_or_else(|| external(path, args)),
            Some(Def::Module(_) | Def::Variant(..) | Def::Function(_) | Def::Value(_)) => Ty::Unknown,
            None => external(format!("?::{}", path.text()), args),
        }
    }

    fn lower_args(&self, segment: Option<&Segment>, scope: &TyScope<'_>, depth: u32) -> Vec<Ty> {
        let args = segment.map_or(&[][..], |segment| &segment.args);
        args.iter()
            .filter_map(|arg| match arg {
                GenericArg::Type(ty) => Some(self.lower_at(ty, scope, depth + 1)),
                GenericArg::Const(_) => Some(Ty::Unknown),
                GenericArg::Assoc(..) | GenericArg::Constraint(..) => None,
            })
            .collect()
    }

    fn complete_args(&self, id: TypeId, mut args: Vec<Ty>) -> Vec<Ty> {
        let wanted = self.type_def(id).generics.params.len();
        args.resize(wanted, Ty::Unknown);
        args
    }

    fn generic_param(&self, name: &str, scope: &TyScope<'_>, depth: u32) -> Option<Ty> {
        if let Some((_, known)) = scope.args.iter().find(|(param, _)| param == name) {
            return Some(known.clone());
        }
        let mut bounds = Vec::new();
        let mut found = false;
        for generics in &scope.generics {
            for param in generics.params.iter().filter(|param| param.name == name && !param.is_const) {
                found = true;
                bounds.extend(self.lower_bounds(&param.bounds, scope, depth + 8));
            }
            for (subject, more) in &generics.predicates {
                if matches!(subject, TypeRef::Path(path) if path.ident() == Some(name)) {
                    bounds.extend(self.lower_bounds(more, scope, depth + 8));
                }
            }
        }
        found.then(|| {
            let resource = self.shared_resource(&bounds);
            resource.unwrap_or_else(|| Ty::Param(Arc::new(ParamTy { name: name.to_owned(), bounds })))
        })
    }

    fn project_in(&self, base: &Ty, name: &str, scope: &TyScope<'_>, depth: u32) -> Ty {
        let found = self.project_at(base, None, name, depth + 1);
        if found != Ty::Unknown {
            return found;
        }
        if let Some(id) = scope.self_impl
            && scope.self_ty.as_ref() == Some(base)
            && let Some(ty) = self.impl_def(id).types.get(name)
        {
            return self.lower_at(ty, scope, depth + 1);
        }
        Ty::Unknown
    }

    /// An associated type of a type: what an impl says, or the bounds that the trait asks for.
    #[must_use]
    pub fn project(&self, base: &Ty, name: &str) -> Ty {
        self.project_at(base, None, name, 0)
    }

    /// The same, of one trait if the path names it. An impl may name the type that is asked for.
    fn project_at(&self, base: &Ty, of: Option<&TraitName>, name: &str, depth: u32) -> Ty {
        if depth > MAX_DEPTH {
            return Ty::Unknown;
        }
        let bounds = match base {
            Ty::Param(param) => &param.bounds,
            Ty::Opaque(bounds) => &**bounds,
            _ => {
                for id in self.impls_of(base) {
                    let def = self.impl_def(id);
                    if of.is_some() && def.implements.as_ref() != of {
                        continue;
                    }
                    if let Some(ty) = def.types.get(name) {
                        let scope = self.scope(def.module, Owner::Impl(id), None);
                        return self.lower_at(ty, &scope, depth + 1).substitute(&self.impl_args(id, base));
                    }
                }
                return Ty::Unknown;
            }
        };
        for bound in bounds {
            if let Some((_, ty)) = bound.assoc.iter().find(|(assoc, _)| assoc == name) {
                return ty.clone();
            }
            if let TraitName::Local(id) = bound.name {
                let def = self.trait_def(id);
                if let Some(bounds) = def.types.get(name) {
                    if let Some(only) = bounds.is_empty().then(|| self.only_type(id, name, depth)).flatten() {
                        return only;
                    }
                    let scope = self.scope(def.module, Owner::Module, Some(&def.generics));
                    return Ty::Opaque(Arc::new(self.lower_bounds(bounds, &scope, 0)));
                }
            }
        }
        Ty::Unknown
    }

    /// An associated type of which the trait says nothing, where one impl alone tells it.
    fn only_type(&self, id: TraitId, name: &str, depth: u32) -> Option<Ty> {
        let [own] = self.impls_of_trait.get(&id)?.as_slice() else { return None };
        let def = self.impl_def(*own);
        let ty = def.types.get(name).filter(|_| def.generics.params.is_empty())?;
        Some(self.lower_at(ty, &self.scope(def.module, Owner::Impl(*own), None), depth + 1))
    }

    /// The type of a field; `variant` is the number of an enum's variant.
    #[must_use]
    pub fn field_ty(&self, ty: &Ty, variant: Option<usize>, field: &str) -> Option<Ty> {
        let Ty::Adt(id, args) = ty else { return None };
        let def = self.type_def(*id);
        let fields = match (&def.shape, variant) {
            (super::Shape::Struct(fields), None) => fields,
            (super::Shape::Enum(variants), Some(number)) => &variants.get(number)?.fields,
            _ => return None,
        };
        let field = fields.fields.iter().find(|candidate| candidate.name == field)?;
        let scope = self.scope(def.module, Owner::Module, Some(&def.generics));
        let args = named_args(&def.generics, args);
        let scope = TyScope { self_ty: Some(ty.clone()), args, ..scope };
        Some(self.lower(&field.ty, &scope))
    }

    /// The name of a type as a reader knows it: `KalmanF`, `Pid<f32>` without its arguments.
    #[must_use]
    pub fn type_name(&self, ty: &Ty) -> String {
        match ty {
            Ty::Adt(id, _) => self.type_def(*id).name.clone(),
            Ty::External(path, _) => path.rsplit("::").next().unwrap_or(path).to_owned(),
            Ty::Ref(_, inner) | Ty::Pointer(inner) => self.type_name(inner),
            Ty::Param(param) => param.name.clone(),
            Ty::Opaque(bounds) => {
                let names: Vec<String> = bounds.iter().map(|bound| self.trait_text(&bound.name)).collect();
                format!("dyn {}", names.join(" + "))
            }
            Ty::Array(inner, _) | Ty::Slice(inner) => self.type_name(inner),
            _ => "_".to_owned(),
        }
    }

    /// The last name of a trait.
    #[must_use]
    pub fn trait_text(&self, name: &TraitName) -> String {
        match name {
            TraitName::Local(id) => self.trait_def(*id).name.clone(),
            TraitName::External(path) => path.rsplit("::").next().unwrap_or(path).to_owned(),
        }
    }
}

/// What the standard library's iterators over collections are as iterators over their items: `slice::IterMut<'_, Pid>`.
fn iterator_of(path: &str, args: &[Ty]) -> Option<Ty> {
    let mut names = path.strip_prefix("std::")?.rsplit("::");
    let (name, module) = (names.next()?, names.next()?);
    let lent = |ty: &Ty| Ty::Ref(name.ends_with("Mut"), Box::new(ty.clone()));
    let is_map = module.ends_with("_map");
    let item = match (module, name, args) {
        (_, "IterMut" | "Iter", [key, value]) if is_map => {
            Ty::Tuple(vec![Ty::Ref(false, Box::new(key.clone())), lent(value)])
        }
        (_, "ValuesMut" | "Values", [_, value]) if is_map => lent(value),
        ("slice", "ChunksMut" | "Chunks" | "ChunksExactMut" | "ChunksExact", [item]) => {
            lent(&Ty::Slice(Box::new(item.clone())))
        }
        ("slice" | "vec_deque" | "linked_list" | "option", "IterMut" | "Iter", [item]) => lent(item),
        ("vec" | "vec_deque" | "linked_list" | "option" | "array", "IntoIter" | "Drain", [item, ..]) => item.clone(),
        _ => return None,
    };
    Some(Ty::std("std::iter::Iterator", vec![item]))
}

/// What an operator makes of two whole numbers.
fn arithmetic(operator: &str, left: u64, right: u64) -> Option<u64> {
    match operator {
        "+" => left.checked_add(right),
        "-" => left.checked_sub(right),
        "*" => left.checked_mul(right),
        "/" => left.checked_div(right),
        _ => None,
    }
}

/// Parameters and the arguments given for them, by name.
pub(super) fn named_args(generics: &Generics, args: &[Ty]) -> Vec<(String, Ty)> {
    generics
        .params
        .iter()
        .zip(args)
        .filter(|(_, ty)| **ty != Ty::Unknown)
        .map(|(param, ty)| (param.name.clone(), ty.clone()))
        .collect()
}

/// A type that is not read. What a lock of `embassy-sync` or `lock_api` locks with stands before its content, and what some vectors
/// hold is written as an array.
fn external(path: String, mut args: Vec<Ty>) -> Ty {
    let is_raw = |ty: &Ty| ty.external_name().is_some_and(|name| name.contains("Raw"));
    let is_lock = path.ends_with("Mutex") || path.ends_with("RwLock");
    if is_lock
        && args.len() > 1
        && (["embassy_sync::", "lock_api::"].iter().any(|of| path.starts_with(of)) || is_raw(&args[0]))
    {
        args.remove(0);
    }
    if let ("SmallVec" | "TinyVec", [Ty::Array(inner, _)]) = (path.rsplit("::").next().unwrap_or(""), args.as_slice()) {
        args = vec![(**inner).clone()];
    }
    Ty::External(path, args)
}

/// The type that the language itself has by that name.
pub(crate) fn primitive(name: &str) -> Option<Ty> {
    Some(match name {
        "u8" | "u16" | "u32" | "u64" | "u128" | "usize" | "i8" | "i16" | "i32" | "i64" | "i128" | "isize" => Ty::Int,
        "f32" | "f64" => Ty::Float,
        "bool" => Ty::Bool,
        "str" => Ty::Str,
        "char" => Ty::Char,
        _ => return None,
    })
}
