//! The walk over a body: scopes, variables, and the order of two passes, the second of which knows what the first found.

use std::collections::BTreeMap;

use rustc_hash::FxHashMap;

use super::indexed::Indexers;
use super::unify::Variables;
use super::{Callee, Local, LocalId, TypedBody};
use crate::index::{BodyOwner, FunctionDef, Index, ModuleId, Owner, Ty, TyScope};
use crate::syntax::spelled;
use crate::syntax::tree::{Body, ExprId, PatId, Receiver};

/// The state of the walk.
pub(super) struct Infer<'a> {
    pub(super) index: &'a Index,
    pub(super) owner: BodyOwner,
    pub(super) body: &'a Body,
    pub(super) scope: TyScope<'a>,
    pub(super) variables: Variables,
    pub(super) typed: TypedBody,
    pub(super) names: Vec<FxHashMap<String, LocalId>>,
    pub(super) output: Ty,
    pub(super) break_tys: Vec<(Option<String>, Ty)>,
    /// What each closure gives back, so that calls of it know.
    pub(super) closure_outputs: FxHashMap<ExprId, Ty>,
    /// What each `[]` of a type of the analysed code may run.
    pub(super) indexers: BTreeMap<ExprId, Indexers>,
    /// Whether the pattern of an arm is bound.
    pub(super) in_arm: bool,
}

pub(super) fn run(index: &Index, owner: BodyOwner) -> Option<TypedBody> {
    let (body, scope, params, output) = match owner {
        BodyOwner::Function(id) => {
            let def = index.function(id);
            let scope = index.scope_of(id);
            let params = param_types(index, def, &scope);
            let output = index.lower(&def.function.output, &scope);
            (def.function.body.as_ref()?, scope, params, output)
        }
        BodyOwner::Value(id) => {
            let def = index.value(id);
            let scope = index.scope(def.module, def.owner, None);
            let output = index.lower(&def.item.ty, &scope);
            (def.item.value.as_ref()?, scope, Vec::new(), output)
        }
    };
    let mut infer = Infer {
        index,
        owner,
        body,
        scope,
        variables: Variables::default(),
        typed: TypedBody { expr_ty: vec![Ty::Unknown; body.exprs.len()], ..TypedBody::default() },
        names: Vec::new(),
        output,
        break_tys: Vec::new(),
        closure_outputs: FxHashMap::default(),
        indexers: BTreeMap::new(),
        in_arm: false,
    };
    for _ in 0..2 {
        infer.pass(&params);
    }
    Some(infer.finish())
}

/// The types of a function's parameters, `self` first.
#[must_use]
pub fn param_types(index: &Index, def: &FunctionDef, scope: &TyScope<'_>) -> Vec<Ty> {
    let mut params = Vec::new();
    if let Some(receiver) = &def.function.receiver {
        let self_ty = scope.self_ty.clone().unwrap_or(Ty::Unknown);
        params.push(match receiver {
            Receiver::Value => self_ty,
            Receiver::Shared => Ty::Ref(false, Box::new(self_ty)),
            Receiver::Exclusive => Ty::Ref(true, Box::new(self_ty)),
            Receiver::Typed(ty) => index.lower(ty, scope),
        });
    }
    params.extend(def.function.params.iter().map(|ty| index.lower(ty, scope)));
    params
}

impl Infer<'_> {
    fn pass(&mut self, params: &[Ty]) {
        self.names = vec![FxHashMap::default()];
        let body = self.body;
        for (number, pat) in body.params.iter().enumerate() {
            let ty = params.get(number).cloned().unwrap_or(Ty::Unknown);
            self.pat(*pat, &ty, None);
        }
        let output = self.output.clone();
        let found = self.expr(body.root, Some(&output));
        self.variables.unify(&output, &found);
    }

    fn finish(mut self) -> TypedBody {
        for ty in &mut self.typed.expr_ty {
            *ty = self.variables.resolve(ty);
        }
        for local in &mut self.typed.locals {
            local.ty = self.variables.resolve(&local.ty);
        }
        for param in self.typed.closure_params.values_mut().flatten() {
            *param = self.variables.resolve(param);
        }
        let called = self.typed.callees.values_mut().filter_map(|callee| match callee {
            Callee::Resolved(resolved) => Some(resolved),
            _ => None,
        });
        for resolved in called.chain(self.typed.items.values_mut()) {
            resolved.self_ty = self.variables.resolve(&resolved.self_ty);
        }
        self.type_tested();
        self.settle_indexed();
        self.typed
    }

    /// The module in which names of this place are looked up.
    pub(super) fn module(&self) -> ModuleId {
        self.scope.module
    }

    /// Runs `inside` with the names of a block that may hold items.
    pub(super) fn in_block<T>(&mut self, block: ExprId, inside: impl FnOnce(&mut Self) -> T) -> T {
        let outer = self.scope.module;
        if let Some(module) = self.index.blocks.get(&(self.owner, block)) {
            self.scope.module = *module;
        }
        let result = self.in_scope(inside);
        self.scope.module = outer;
        result
    }

    /// Runs `inside` with a scope of its own for variables.
    pub(super) fn in_scope<T>(&mut self, inside: impl FnOnce(&mut Self) -> T) -> T {
        self.names.push(FxHashMap::default());
        let result = inside(self);
        self.names.pop();
        result
    }

    /// The variable with that name.
    pub(super) fn lookup(&self, name: &str) -> Option<LocalId> {
        self.names.iter().rev().find_map(|scope| scope.get(name).copied())
    }

    /// Binds the name of a pattern; the second pass finds the variable of the first.
    pub(super) fn bind(&mut self, pat: PatId, name: &str, ty: &Ty, by_ref: bool) {
        let known = self.typed.pat_local.get(&pat).copied();
        let id = known.unwrap_or_else(|| {
            let id = LocalId(u32::try_from(self.typed.locals.len()).expect("fewer than 2^32 variables"));
            let span = self.body.pat(pat).span;
            let ty = self.variables.fresh();
            self.typed.locals.push(Local { name: spelled(name).to_owned(), ty, span, by_ref });
            self.typed.pat_local.insert(pat, id);
            id
        });
        let declared = self.typed.locals[id.0 as usize].ty.clone();
        self.variables.unify(&declared, ty);
        if let Some(scope) = self.names.last_mut() {
            scope.insert(name.to_owned(), id);
        }
    }

    /// The scope of an owner's own signature.
    pub(super) fn owner_scope(&self, module: ModuleId, owner: Owner) -> TyScope<'_> {
        self.index.scope(module, owner, None)
    }
}
