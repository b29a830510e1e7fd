//! Where functions are called: how often, and how often inside a loop or a function that is called once per cycle.

use std::collections::{BTreeMap, BTreeSet};

use super::Uses;
use crate::count::is_cycle_function;
use crate::flow::Program;
use crate::index::{FunctionDef, FunctionId, Index, MethodOwner, Owner, TraitName};
use crate::source::Span;
use crate::syntax::tree::{Body, ExprKind, Receiver};
use crate::types::Callee;

/// Every call that was read, tests apart.
#[derive(Debug, Default)]
pub(super) struct Calls {
    /// The calls of each function; a call through a trait that may run several bodies counts for its declaration only.
    of: BTreeMap<FunctionId, Uses>,
    /// Functions that are called from outside the methods of their own type.
    pub(super) from_elsewhere: BTreeSet<FunctionId>,
    /// Functions whose name is given to another function.
    pub(super) handed_over: BTreeSet<FunctionId>,
}

/// A call.
struct Site {
    caller: FunctionId,
    target: FunctionId,
    in_loop: bool,
    /// Whether nothing else may run.
    is_sure: bool,
}

impl Calls {
    pub(super) fn read(program: &Program<'_>) -> Self {
        let index = program.index;
        let mut calls = Self::default();
        let mut sites: Vec<Site> = Vec::new();
        for caller in index.function_ids() {
            let def = index.function(caller);
            let (Some(body), Some(typed)) = (&def.function.body, program.typed(caller)) else { continue };
            if is_test(index, def) {
                continue;
            }
            let loops = loops(body);
            for (at, callee) in &typed.callees {
                let span = body.expr(*at).span;
                let in_loop = loops.iter().any(|own| own.contains(span));
                if let Callee::Resolved(resolved) = callee {
                    let declared = resolved.owner.as_ref().and_then(|owner| declaration(index, owner));
                    let is_sure = resolved.targets.len() == 1;
                    let targets = resolved.targets.iter().map(|target| (*target, is_sure));
                    let declared = declared.filter(|id| !resolved.targets.contains(id)).map(|id| (id, true));
                    sites.extend(targets.chain(declared).map(|(target, is_sure)| Site {
                        caller,
                        target,
                        in_loop,
                        is_sure,
                    }));
                }
                if let ExprKind::Call { args, .. } | ExprKind::MethodCall { args, .. } = &body.expr(*at).kind {
                    let is_seen = matches!(callee, Callee::Builtin | Callee::Constructor(_));
                    for arg in args {
                        if let Some(crate::index::Def::Function(id)) = typed.expr_def.get(arg)
                            && !is_seen
                        {
                            calls.handed_over.insert(*id);
                        }
                    }
                }
            }
        }
        let called: BTreeSet<FunctionId> =
            sites.iter().filter(|site| site.caller != site.target).map(|site| site.target).collect();
        for Site { caller, target, in_loop, is_sure } in sites {
            let is_cycle = is_cycle_function(index, caller)
                || (!called.contains(&caller) && takes_state(index.function(caller)) && !in_loop);
            let uses = calls.of.entry(target).or_default();
            if owner_type(index, caller) != owner_type(index, target) || owner_type(index, target).is_none() {
                uses.calls += usize::from(is_sure);
                uses.in_cycles += usize::from(is_sure && (in_loop || is_cycle));
                uses.by_trait += usize::from(!is_sure);
                calls.from_elsewhere.insert(target);
            }
        }
        calls
    }

    /// Whether any code that was read calls it.
    pub(super) fn is_called(&self, id: FunctionId) -> bool {
        self.of.contains_key(&id)
    }

    pub(super) fn uses(&self, id: FunctionId) -> Uses {
        self.of.get(&id).copied().unwrap_or_default()
    }
}

/// The declaration of a method that a call means: of one that a type has by a trait, that in the trait.
fn declaration(index: &Index, owner: &MethodOwner) -> Option<FunctionId> {
    let id = owner.function()?;
    match owner {
        MethodOwner::Implemented(TraitName::Local(of), _) => {
            index.trait_def(*of).methods.get(&index.function(id).name).copied()
        }
        _ => Some(id),
    }
}

/// The loops of a body.
pub(super) fn loops(body: &Body) -> Vec<Span> {
    let spans = body.exprs.iter().filter_map(|expr| match &expr.kind {
        ExprKind::Loop { body: inner, .. }
        | ExprKind::While { body: inner, .. }
        | ExprKind::For { body: inner, .. } => Some(body.expr(*inner).span),
        _ => None,
    });
    spans.collect()
}

/// Whether the function belongs to tests or benchmarks.
pub(super) fn is_test(index: &Index, def: &FunctionDef) -> bool {
    def.is_test || index.crate_of(def.module).is_test || index.module(def.module).is_test
}

/// Whether a function can keep something from call to call: in `&mut self`, or behind a `&mut` parameter.
pub(super) fn takes_state(def: &FunctionDef) -> bool {
    let is_exclusive =
        |ty: &crate::syntax::tree::TypeRef| matches!(ty, crate::syntax::tree::TypeRef::Reference { mutable: true, .. });
    def.function.receiver == Some(Receiver::Exclusive) || def.function.params.iter().any(is_exclusive)
}

/// The type whose method it is.
pub(super) fn owner_type(index: &Index, id: FunctionId) -> Option<crate::index::TypeId> {
    match index.function(id).owner {
        Owner::Impl(owner) => match &index.impl_def(owner).self_ty {
            crate::index::Ty::Adt(id, _) => Some(*id),
            _ => None,
        },
        _ => None,
    }
}
