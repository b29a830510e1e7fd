//! Method calls: which method of the receiver's type is meant, through references, pointers and `Deref`.

use super::builtin;
use super::closure_params::{closure_params, held_callback};
use super::infer::Infer;
use super::inherent::has_own;
use super::primitive;
use super::probing::Form;
use super::{Callee, Resolved};
use crate::index::{FunctionId, MethodOwner, Owner, Shape, TraitName, Ty};
use crate::syntax::tree::{Block, ExprId, ExprKind, Path, Receiver, TypeRef};

impl Infer<'_> {
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
        let mut form = Form::Value;
        for _ in 0..12 {
            let lent_as = std::mem::replace(&mut form, Form::Value);
            match &ty {
                Ty::Ref(mutable, inner) => {
                    form = Form::of_reference(*mutable);
                    let inner = self.variables.shallow(&inner.clone());
                    if let Some(owner) = self.extension(&ty, method, args)
                        && self.methods_of(&inner, method).is_empty()
                    {
                        return self.resolved_method(id, owner, &ty, (method, turbofish), args, derefs);
                    }
                    ty = inner;
                }
                Ty::Bool | Ty::Int | Ty::Float | Ty::Char | Ty::Str => match self.extension(&ty, method, args) {
                    Some(owner) => {
                        return self.resolved_method(id, owner, &ty, (method, turbofish), args, derefs);
                    }
                    None => break,
                },
                Ty::Pointer(_) => break,
                Ty::Adt(..) | Ty::Param(_) | Ty::Opaque(_) => {
                    let owners = self.methods_of(&ty, method);
                    if let Some((owner, of)) = self.probed(&ty, lent_as, method, args, owners) {
                        return self.resolved_method(id, owner, &of, (method, turbofish), args, derefs);
                    }
                    // An iterator of which only the bounds are known has the methods of all iterators.
                    if let Some(item) = ty.items().cloned()
                        && let Some(output) = self.builtin_call(id, &builtin::iterator(item), method, args)
                    {
                        return output;
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
                    let owners = if has_own(path, method) { Vec::new() } else { self.methods_of(&ty, method) };
                    let probed = self.probed(&ty, lent_as, method, args, owners);
                    if let Some((owner, of)) = probed.filter(|(owner, _)| !self.is_forwarded(owner, &ty, method)) {
                        return self.resolved_method(id, owner, &of, (method, turbofish), args, derefs);
                    }
                    if let Some(spec) = self.index.law_spec(&ty) {
                        let law = spec.group(method);
                        // What makes a filter may have given a `Result` of it.
                        if law.is_none() && matches!(method, "unwrap" | "expect" | "unwrap_or_else") {
                            for arg in args {
                                self.expr(*arg, None);
                            }
                            self.typed.callees.insert(id, Callee::Builtin);
                            return ty;
                        }
                        let made = self.external_filter_method(id, &ty, law, args, derefs);
                        // A method of a filter that has no name yet goes on building it.
                        let is_building = law.is_none() && !args.is_empty() && !self.is_place(receiver);
                        return if is_building { ty } else { made };
                    }
                    if let Some(made) = self.builder_method(id, path, method, args) {
                        return made;
                    }
                    if !self.is_of_content(&ty, method, args)
                        && let Some(output) = self.builtin_call(id, &ty, method, args)
                    {
                        return output;
                    }
                    match (path.rsplit("::").next().unwrap_or(""), params.as_slice()) {
                        (name, [inner, ..]) if builtin::is_pointer(name) => {
                            ty = self.variables.shallow(&inner.clone());
                        }
                        // A list has the methods of slices.
                        ("Vec" | "ArrayVec" | "SmallVec", [item, ..]) => ty = Ty::Slice(Box::new(item.clone())),
                        _ => break,
                    }
                }
                Ty::Array(..) | Ty::Slice(_) => {
                    let owners = self.methods_of(&ty, method);
                    if let Some(owner) = owners.into_iter().next() {
                        return self.resolved_method(id, owner, &ty, (method, turbofish), args, derefs);
                    }
                    match (self.builtin_call(id, &ty, method, args), &ty) {
                        (Some(output), _) => return output,
                        // A clone of an array is one of the same length.
                        (None, Ty::Array(..)) if method == "clone" && args.is_empty() => break,
                        (None, Ty::Array(item, _)) => ty = Ty::Slice(item.clone()),
                        (None, _) => break,
                    }
                }
                Ty::Tuple(_) => {
                    let owners = self.methods_of(&ty, method);
                    if let Some(owner) = owners.into_iter().next() {
                        return self.resolved_method(id, owner, &ty, (method, turbofish), args, derefs);
                    }
                    match (method == "lock").then(|| self.builtin_call(id, &ty, method, args)).flatten() {
                        Some(output) => return output,
                        None => break,
                    }
                }
                Ty::Var(_) => match self.variables.origin(&ty).cloned() {
                    // What has the law called on it is the filter.
                    Some(origin) if self.is_law(&origin.filter, method) => {
                        self.variables.unify(&ty, &origin.filter);
                        ty = origin.filter;
                    }
                    Some(origin) => return self.method_of_unread(id, (&ty, &origin), method, turbofish, args),
                    None => break,
                },
                _ => break,
            }
        }
        self.unresolved_method(id, &ty, method, turbofish, args)
    }

    /// The method that a trait of the analysed code gives to a primitive type or a reference, if it may do something: what takes
    /// nothing but a value only calculates.
    pub(super) fn extension(&self, ty: &Ty, method: &str, args: &[ExprId]) -> Option<MethodOwner> {
        // What takes another number of arguments is not meant: it may belong to a trait that is not in scope.
        let takes_all = |owner: &MethodOwner| {
            let params = owner.function().map(|function| self.index.function(function).function.params.len());
            params.is_none_or(|params| params == args.len())
        };
        let owner = self.index.extension_methods(ty, method).into_iter().find(takes_all)?;
        let takes_itself = owner.function().is_some_and(|function| {
            let receiver = &self.index.function(function).function.receiver;
            *receiver == Some(Receiver::Exclusive) || matches!(ty, Ty::Ref(..))
        });
        (takes_itself || !args.is_empty()).then_some(owner)
    }

    /// Whether a method of a pointer is ceid-core's, and what it points to has its own, which is what code outside of ceid-core
    /// means.
    fn is_forwarded(&self, owner: &MethodOwner, pointer: &Ty, method: &str) -> bool {
        let Ty::External(path, params) = pointer else { return false };
        let is_of_core = owner
            .function()
            .is_some_and(|function| self.index.crate_of(self.index.function(function).module).name == "ceid_core");
        is_of_core
            && builtin::is_pointer(path.rsplit("::").next().unwrap_or(""))
            && params
                .first()
                .is_some_and(|inner| !self.index.methods(&self.variables.shallow(inner), method).is_empty())
    }

    /// Whether a method is a written `Clone::clone` that gives each field of a state anew: `Self { y: self.y, gain: self.gain }`.
    fn clones_all(&self, owner: &MethodOwner, ty: &Ty) -> bool {
        let MethodOwner::Implemented(TraitName::External(path), function) = owner else { return false };
        let (Ty::Adt(id, _), Some(body)) = (ty, &self.index.function(*function).function.body) else { return false };
        let Shape::Struct(of_type) = &self.index.type_def(*id).shape else { return false };
        let mut at = body.root;
        while let ExprKind::Block(Block { stmts, tail: Some(tail), .. }) = &body.expr(at).kind
            && stmts.is_empty()
        {
            at = *tail;
        }
        let gives_all = match &body.expr(at).kind {
            ExprKind::Struct { fields, rest: None, .. } => fields.len() == of_type.fields.len(),
            ExprKind::Deref(_) => true,
            _ => false,
        };
        let shares = &mut |part: &Ty| part.is_shared_pointer() || matches!(part, Ty::Ref(..) | Ty::Pointer(_));
        let mut fields = of_type.fields.iter().filter_map(|field| self.index.field_ty(ty, None, &field.name));
        path == "std::clone::Clone"
            && gives_all
            && self.index.holds_filter(ty)
            && !fields.any(|field| field.has_part(shares))
    }

    /// Whether an expression names a place, and is no value that was just made.
    fn is_place(&self, id: ExprId) -> bool {
        match &self.body.expr(id).kind {
            ExprKind::Path(_) | ExprKind::Field { .. } | ExprKind::Index { .. } | ExprKind::Deref(_) => true,
            ExprKind::Reference { value, .. } => self.is_place(*value),
            // What a lock or an `Option` hands out lies in a place, too.
            ExprKind::MethodCall { receiver, .. } => {
                !matches!(self.typed.callees.get(&id), Some(Callee::External(_)))
                    && !matches!(self.body.expr(*receiver).kind, ExprKind::Call { .. })
                    && self.is_place(*receiver)
            }
            ExprKind::Try(inner) | ExprKind::Await(inner) => self.is_place(*inner),
            _ => false,
        }
    }

    pub(super) fn unresolved_method(
        &mut self,
        id: ExprId,
        ty: &Ty,
        method: &str,
        turbofish: &[TypeRef],
        args: &[ExprId],
    ) -> Ty {
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
        // No method of theirs takes a closure or writes what it is given.
        let takes_more = |arg: &ExprId| {
            let kind = &self.body.expr(*arg).kind;
            matches!(kind, ExprKind::Closure(_) | ExprKind::Reference { mutable: true, .. })
        };
        let is_builtin = match ty {
            Ty::Int | Ty::Float | Ty::Bool | Ty::Char => method == "hash" || !args.iter().any(takes_more),
            _ => matches!(ty, Ty::Str | Ty::Tuple(_)),
        };
        self.typed.callees.insert(id, if is_builtin { Callee::Builtin } else { Callee::Unknown });
        match (ty, method) {
            // Whatever it is zipped with, the items of what is known are known.
            (_, "zip") => {
                let other =
                    args.first().map_or(Ty::Unknown, |arg| self.shallow_deep(&self.typed.expr_ty[arg.0 as usize]));
                match builtin::item_of(&other, false) {
                    Some(item) => builtin::iterator(Ty::Tuple(vec![Ty::Unknown, item])),
                    None => Ty::Unknown,
                }
            }
            (_, "next_cycle") => Ty::std("std::option::Option", vec![Ty::std("ceid_core::Cycle", Vec::new())]),
            (_, "clone" | "to_owned") => ty.clone(),
            // Whatever a primitive is asked, the answer is a truth value.
            (Ty::Int | Ty::Float | Ty::Char | Ty::Str, _) if method.starts_with("is_") => Ty::Bool,
            (Ty::Int | Ty::Float, _) if !matches!(method, "into" | "try_into") => primitive::given_by(ty, method),
            (_, "into") => turbofish.first().map_or(Ty::Unknown, |ty| self.index.lower(ty, &self.scope)),
            (_, "parse" | "try_into") => {
                let made = turbofish.first().map_or(Ty::Unknown, |ty| self.index.lower(ty, &self.scope));
                Ty::std("std::result::Result", vec![made, Ty::Unknown])
            }
            (Ty::Char | Ty::Str | Ty::External(..), _) => primitive::given_by(ty, method),
            _ => Ty::Unknown,
        }
    }

    /// `Mutex::lock(&lpf)`, `Iterator::next(&mut filters)`: a method of the standard library that is called by its path.
    pub(super) fn path_method(&mut self, id: ExprId, owner: &Ty, method: &str, args: &[ExprId]) -> Option<Ty> {
        let (first, rest) = args.split_first()?;
        let Ty::External(path, _) = owner else { return None };
        let found = self.expr(*first, None);
        let mut receiver = self.variables.shallow(&found);
        loop {
            let inner = match &receiver {
                Ty::Ref(_, inner) => inner,
                Ty::External(own, _) if has_methods_of(own, path) => break,
                // The argument is a reference to what the pointer holds.
                Ty::External(own, params) if builtin::is_pointer(own.rsplit("::").next().unwrap_or("")) => {
                    params.first()?
                }
                _ if is_method_trait(path) => break,
                _ => return None,
            };
            receiver = self.variables.shallow(inner);
        }
        self.builtin_call(id, &receiver, method, rest)
    }

    fn builtin_call(&mut self, id: ExprId, receiver: &Ty, method: &str, args: &[ExprId]) -> Option<Ty> {
        let body = self.body;
        let receiver = self.shallow_deep(receiver);
        let held = held_callback(&receiver);
        let mut given: Vec<Ty> = Vec::new();
        for arg in args {
            let is_closure = matches!(body.expr(*arg).kind, ExprKind::Closure(_));
            // What is put into a queue of callbacks is one: `later.push(Box::new(|rig| rig.step()))`.
            let is_made = matches!(body.expr(*arg).kind, ExprKind::Call { .. });
            given.push(if is_closure { Ty::Unknown } else { self.expr(*arg, held.filter(|_| is_made)) });
        }
        let mut closure_output = None;
        for arg in args {
            if let ExprKind::Closure(closure) = &body.expr(*arg).kind {
                let params = closure_params(&receiver, method, &given);
                let ty = self.closure(*arg, closure, &params);
                self.typed.expr_ty[arg.0 as usize] = ty;
                closure_output = self.closure_outputs.get(arg).map(|ty| self.variables.shallow(ty));
            }
        }
        let given: Vec<Ty> = given.iter().map(|ty| self.shallow_deep(ty)).collect();
        if let (None, Some(last), Some(found)) = (&closure_output, args.last(), given.last()) {
            closure_output = self.output_of_named(*last, found, closure_params(&receiver, method, &given).first());
        }
        let output = builtin::method(&receiver, method, &given, closure_output.as_ref())?;
        // A collection learns what it holds from what is put into it.
        let is_made = matches!(method, "get_or_insert_with" | "or_insert_with" | "get_or_init" | "resize_with");
        let put_in = if is_made { closure_output.as_slice() } else { &given };
        if (is_made
            || matches!(method, "push" | "push_back" | "push_front" | "insert" | "resize")
            || matches!(method, "get_or_insert" | "or_insert" | "replace" | "set"))
            && let Ty::External(path, params) = &receiver
        {
            // Behind what it holds, there may be how much of it.
            let held = if builtin::family(path).ends_with("Map") { 2 } else { 1 };
            for (param, found) in params.iter().take(held).rev().zip(put_in.iter().rev()) {
                self.variables.unify(param, found);
            }
        }
        if let ("extend" | "extend_from_slice" | "append", Some(from)) = (method, given.first()) {
            // Of shared references, their values may be copied; of what is lent as a whole, clones or the elements themselves go in.
            let item = self.item_ty(if method == "extend" { from } else { from.peel() });
            if !matches!(item, Ty::Ref(false, _)) {
                self.collect_into(&receiver, &item);
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
        (method, turbofish): (&str, &[TypeRef]),
        args: &[ExprId],
        derefs: Vec<FunctionId>,
    ) -> Ty {
        if method == "clone" && derefs.is_empty() && self.clones_all(&owner, ty) {
            // It does what a derived one does.
            return self.unresolved_method(id, ty, method, turbofish, args);
        }
        let law = self.law_of(ty, method, &owner);
        let output = match owner.function() {
            Some(function) => {
                let written = self.turbofish_types(function, turbofish);
                self.instantiate(function, Some(ty), args, true, (written, None))
            }
            None => {
                let items = ty.items().cloned().map(builtin::iterator);
                let known = items.and_then(|items| self.builtin_call(id, &items, method, args));
                known.unwrap_or_else(|| {
                    for arg in args {
                        self.expr(*arg, None);
                    }
                    Ty::Unknown
                })
            }
        };
        let targets = self.bodies(&owner, ty, method, args);
        let resolved = Resolved { targets, owner: Some(owner), law, self_ty: ty.clone(), has_receiver: true, derefs };
        self.typed.callees.insert(id, Callee::Resolved(resolved));
        output
    }

    /// The methods of a type, as far as its arguments are known by now.
    pub(super) fn methods_of(&self, ty: &Ty, name: &str) -> Vec<MethodOwner> {
        match ty {
            Ty::Adt(_, args) if !args.is_empty() => self.index.methods(&self.variables.resolve(ty), name),
            _ => self.index.methods(ty, name),
        }
    }

    pub(super) fn targets(&self, owner: &MethodOwner, name: &str) -> Vec<FunctionId> {
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
                if let (true, TraitName::External(path)) = (targets.is_empty(), of) {
                    targets = self.index.foreign_bodies(path, name);
                }
                targets
            }
        }
    }

    /// The bodies that a call may run of an associated function that was found. Several impls can have it: for other arguments of
    /// the type, and of other arguments of the trait. Those count that are for the type at hand, and take what is given beside `self`.
    pub(super) fn bodies(&self, owner: &MethodOwner, ty: &Ty, name: &str, given: &[ExprId]) -> Vec<FunctionId> {
        let mut targets = self.targets(owner, name);
        if targets.len() > 1 {
            self.leave_possible(&mut targets, ty, given);
            return targets;
        }
        let Some(function) = owner.function().filter(|_| targets.len() == 1) else { return targets };
        let Owner::Impl(of) = self.index.function(function).owner else { return targets };
        let def = self.index.impl_def(of);
        let has_args = |path: &Path| path.segments.last().is_some_and(|segment| !segment.args.is_empty());
        let is_one_of_several = matches!(&def.self_ty, Ty::Adt(_, args) if !args.is_empty());
        if !is_one_of_several && !def.trait_path.as_ref().is_some_and(has_args) {
            return targets;
        }
        let is_alike = |other: &MethodOwner| other.of_trait() == owner.of_trait();
        let mut own: Vec<FunctionId> = self
            .methods_of(ty, name)
            .iter()
            .filter(|other| is_alike(other))
            .filter_map(MethodOwner::function)
            .collect();
        own.dedup();
        if own.is_empty() {
            return targets;
        }
        let fitting: Vec<FunctionId> = own.iter().copied().filter(|body| self.takes(*body, given)).collect();
        if fitting.is_empty() { own } else { fitting }
    }

    /// Leaves of the bodies of a trait's method those of types that may have all traits which are asked for, where these take what is
    /// given beside `self`.
    fn leave_possible(&self, targets: &mut Vec<FunctionId>, ty: &Ty, given: &[ExprId]) {
        let bounds = match ty {
            Ty::Param(param) => param.bounds.as_slice(),
            Ty::Opaque(bounds) => bounds.as_slice(),
            _ => return,
        };
        let is_possible = |body: &FunctionId| match self.index.function(*body).owner {
            Owner::Impl(of) => bounds.iter().all(|bound| self.index.may_have(of, bound)) && self.takes(*body, given),
            Owner::Trait(_) | Owner::Module => true,
        };
        let possible: Vec<FunctionId> = targets.iter().copied().filter(is_possible).collect();
        if !possible.is_empty() {
            *targets = possible;
        }
    }

    /// Whether a body may have what is given for its parameters beside `self`. What dereferences to another type may be lent as that.
    fn takes(&self, body: FunctionId, given: &[ExprId]) -> bool {
        let scope = self.index.scope_of(body);
        let mut params = self.index.function(body).function.params.iter().zip(given);
        params.all(|(param, arg)| {
            let found = self.variables.resolve(&self.typed.expr_ty[arg.0 as usize]);
            match (self.index.lower(param, &scope).peel(), found.peel()) {
                (wanted @ Ty::Adt(..), found @ Ty::Adt(..)) => wanted.may_be(found) || self.user_deref(found).is_some(),
                _ => true,
            }
        })
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

/// Whether a type outside the analysed code has the methods that a path of the standard library names.
fn has_methods_of(own: &str, path: &str) -> bool {
    own == path || is_method_trait(path) || (own.ends_with("::LockResult") && path == "std::result::Result")
}

/// Traits of the standard library whose methods the types themselves are asked for.
fn is_method_trait(path: &str) -> bool {
    matches!(
        path,
        "std::iter::Iterator"
            | "std::iter::IntoIterator"
            | "std::clone::Clone"
            | "std::convert::AsMut"
            | "std::convert::AsRef"
            | "std::borrow::Borrow"
            | "std::borrow::BorrowMut"
            | "std::ops::Deref"
            | "std::ops::DerefMut"
    )
}
