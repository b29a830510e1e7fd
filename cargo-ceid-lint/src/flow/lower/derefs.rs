//! `Deref` impls of the analysed code: the place that one hands out, and what it does before.

use std::sync::Arc;

use super::{Builder, Value};
use crate::flow::{Place, Projection, Steps};
use crate::index::{FunctionId, MethodOwner, Ty};
use crate::source::Span;
use crate::syntax::tree::{Body, ExprId, ExprKind};
use crate::types::{Callee, is_lock};

/// How many `Deref` impls are gone through.
const MAX_DEREFS: usize = 4;

/// What a `deref` hands out.
struct DerefPath {
    /// The way from `self`.
    steps: Steps,
    /// Whether it does nothing else.
    is_all: bool,
}

impl Builder<'_> {
    /// A field of a place, through the `Deref` impls of newtypes.
    pub(super) fn field_place(&self, base: ExprId, place: &Place, name: &str) -> Place {
        if let Some(place) = self.field_of_other_name(base, name) {
            return place;
        }
        let derefs = self.derefs_before(base, name);
        derefs.iter().fold(place.clone(), |place, through| self.named_by_deref(place, *through)).field(name)
    }

    /// The place that a `deref` names, whatever else it does.
    pub(super) fn named_by_deref(&self, place: Place, through: FunctionId) -> Place {
        match self.through_deref(through) {
            Some(path) => place.join(&path.steps),
            None => place,
        }
    }

    /// The same, with what the `Deref` impls do.
    pub(super) fn read_field(&mut self, base: ExprId, place: Place, name: &str) -> Place {
        if let Some(place) = self.field_of_other_name(base, name) {
            return place;
        }
        let span = self.span(base);
        let derefs = self.derefs_before(base, name);
        derefs.into_iter().fold(place, |place, through| self.dereferenced(place, through, span)).field(name)
    }

    /// The `Deref` impls that lead from a value to the field of that name.
    fn derefs_before(&self, base: ExprId, name: &str) -> Vec<FunctionId> {
        let mut ty = self.ty(base).peel().clone();
        let mut derefs = Vec::new();
        for _ in 0..MAX_DEREFS {
            match &ty {
                Ty::External(_, args) if !args.is_empty() => ty = args[0].peel().clone(),
                Ty::Adt(..) if self.program.index.field_ty(&ty, None, name).is_none() => {
                    let Some((target, through)) = self.deref_target(&ty) else { break };
                    derefs.push(through);
                    ty = target.peel().clone();
                }
                _ => break,
            }
        }
        derefs
    }

    fn deref_target(&self, ty: &Ty) -> Option<(Ty, FunctionId)> {
        let index = self.program.index;
        let target = index.project(ty, "Target");
        let through =
            index.methods(ty, "deref_mut").into_iter().chain(index.methods(ty, "deref")).next()?.function()?;
        (target != Ty::Unknown).then_some((target, through))
    }

    /// The place that a `deref` or `deref_mut` of the analysed code hands out, with what it does before.
    pub(super) fn dereferenced(&mut self, place: Place, through: FunctionId, span: Span) -> Place {
        match self.through_deref(through) {
            Some(path) if path.is_all => place.join(&path.steps),
            _ if self.at.is_none() => place,
            _ => {
                let index = self.program.index;
                let function = &index.function(through).function;
                let output = index.lower(&function.output, &index.scope_of(through));
                Place::var(self.run_on(through, place, output, "deref".to_owned(), span))
            }
        }
    }

    /// The field that the body of a `deref` or `deref_mut` names; `None` if it hands out something else.
    fn through_deref(&self, function: FunctionId) -> Option<DerefPath> {
        let body = self.program.index.function(function).function.body.as_ref()?;
        let mut id = body.root;
        let mut is_all = true;
        while let ExprKind::Block(block) = &body.expr(id).kind {
            is_all &= block.stmts.is_empty();
            id = block.tail?;
        }
        Some(DerefPath { steps: field_steps(body, id)?, is_all })
    }

    /// A reference to what `Deref` impls hand out, where that is asked for and one to its owner is given.
    pub(super) fn coerced(&mut self, id: ExprId, mut value: Value) -> Value {
        if let Some(derefs) = self.typed().coerced.get(&id)
            && let Some(place) = value.place.take()
        {
            let span = self.span(id);
            let through = |place: Place, through: &FunctionId| self.dereferenced(place, *through, span);
            value.place = Some(derefs.iter().fold(place, through));
        }
        value
    }

    /// Whether what is called takes an argument by a shared reference, whatever it is given: `show(lag)` of a `fn(&Lag)`.
    pub(super) fn is_taken_shared(&self, id: ExprId, arg: ExprId) -> bool {
        let (callee, receiver, args) = match &self.body().expr(id).kind {
            ExprKind::Call { callee, args } => (Some(*callee), None, args),
            ExprKind::MethodCall { receiver, args, .. } => (None, Some(*receiver), args),
            _ => return false,
        };
        let Some(number) = receiver.iter().chain(args).position(|own| *own == arg) else { return false };
        let wanted = match (self.typed().callees.get(&id), callee) {
            (Some(Callee::Resolved(resolved)), _) => {
                let declared = resolved.owner.as_ref().and_then(MethodOwner::function);
                let function = resolved.targets.first().copied().or(declared);
                function.map(|function| self.declared_param(function, number))
            }
            (_, Some(callee)) => {
                let local = self.typed().expr_local.get(&callee);
                match local.map_or(self.ty(callee), |local| &self.typed().local(*local).ty).peel() {
                    Ty::Function(params, _) => params.get(number).cloned(),
                    ty => ty.called_as().and_then(|(params, _)| params.get(number).cloned()),
                }
            }
            _ => None,
        };
        wanted.is_some_and(|ty| matches!(&ty, Ty::Ref(false, own) if self.program.index.shares_no_filter(own, is_lock)))
    }
}

/// The way from `self` to a field, through references; `None` if an expression is something else.
pub(super) fn field_steps(body: &Body, id: ExprId) -> Option<Steps> {
    let mut steps = Vec::new();
    let mut at = id;
    loop {
        match &body.expr(at).kind {
            ExprKind::Reference { value, .. } | ExprKind::Deref(value) => at = *value,
            ExprKind::Field { base, name } => {
                steps.push(Projection::Field(Arc::from(name.as_str())));
                at = *base;
            }
            ExprKind::Path(path) if path.ident() == Some("self") => break,
            _ => return None,
        }
    }
    steps.reverse();
    Some(steps.into())
}
