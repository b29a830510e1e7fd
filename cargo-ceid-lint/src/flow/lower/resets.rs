//! Resets that are known by their names: whether their bodies write the whole state.

use std::collections::BTreeSet;

use super::Builder;
use super::written::{cleared_fields, written_fields};
use crate::flow::Head;
use crate::index::{FunctionId, Owner, Ty};
use crate::syntax::tree::{ExprId, ExprKind};
use crate::types::Callee;

impl<'a> Builder<'a> {
    /// Whether a reset known by its name writes the whole state: every field that the law writes, or `*self`. The heads are those of
    /// its arguments.
    pub(super) fn is_full_reset(&self, reset: FunctionId, self_ty: &Ty, heads: &[Option<Head>]) -> bool {
        let index = self.program.index;
        let Some(cleared) = cleared_fields(self.program, reset, heads) else { return true };
        // Behind a trait the type is that of the impl.
        let self_ty = match index.function(reset).owner {
            Owner::Impl(of) if !matches!(self_ty.peel(), Ty::Adt(..)) => &index.impl_def(of).self_ty,
            _ => self_ty,
        };
        let laws = index.methods(self_ty, "update");
        let mut state = BTreeSet::new();
        for law in laws.iter().filter_map(crate::index::MethodOwner::function) {
            match written_fields(self.program, law) {
                Some(fields) => state.extend(fields),
                None => return !cleared.is_empty(),
            }
        }
        state.is_subset(&cleared)
    }

    /// The fields that the laws of a filter type write; none if that cannot be seen.
    pub(super) fn state_fields(&self, ty: &Ty) -> BTreeSet<String> {
        let index = self.program.index;
        let Some(spec) = index.filter_spec(ty) else { return BTreeSet::new() };
        let methods = spec.law.iter().flat_map(|group| &group.methods).flat_map(|name| index.methods(ty, name));
        let laws = methods.filter_map(|owner| owner.function());
        let mut state = BTreeSet::new();
        for law in laws {
            match written_fields(self.program, law) {
                Some(fields) => state.extend(fields),
                None => return BTreeSet::new(),
            }
        }
        state
    }

    /// Whether what a filter is assigned is made of its own state, so that the assignment is no full reset:
    /// `filter = Filter { gain: 0.5, ..filter }`.
    pub(super) fn keeps_state(&mut self, target: ExprId, value: ExprId) -> bool {
        let ty = self.ty(target).peel().clone();
        if self.program.index.filter_spec(&ty).is_none() {
            return false;
        }
        let Some(old) = self.static_place(target) else { return false };
        let body = self.body();
        match &body.expr(value).kind {
            ExprKind::Path(_) | ExprKind::Field { .. } => self.static_place(value) == Some(old),
            ExprKind::MethodCall { method, .. } if method == "clone" => {
                self.static_place(self.cloned(value)) == Some(old)
            }
            ExprKind::MethodCall { receiver, .. } if self.static_place(*receiver).as_ref() == Some(&old) => {
                self.gives_itself_back(value, &ty)
            }
            ExprKind::Struct { fields, rest, .. } => {
                let is_rest = rest.is_some_and(|rest| self.static_place(self.cloned(rest)).as_ref() == Some(&old));
                let kept = |this: &mut Self, name: &String| match fields.iter().find(|(field, _)| field == name) {
                    Some((_, value)) => this.computed_from(*value).places.contains(&old.field(name)),
                    None => is_rest,
                };
                let state = self.state_fields(&ty);
                if state.is_empty() { is_rest } else { state.iter().any(|name| kept(self, name)) }
            }
            _ => false,
        }
    }

    /// The new fields of a filter that is assigned with the rest of itself: `filter = Filter { gain: 0.5, ..filter }`.
    pub(super) fn own_rest(&mut self, target: ExprId, value: ExprId) -> Option<&'a [(String, ExprId)]> {
        let body = self.body();
        let ExprKind::Struct { fields, rest: Some(rest), .. } = &body.expr(value).kind else { return None };
        let is_filter = self.program.index.filter_spec(self.ty(target).peel()).is_some();
        let own = self.static_place(target).filter(|_| is_filter)?;
        (self.static_place(self.cloned(*rest)) == Some(own)).then_some(fields.as_slice())
    }

    /// What an expression clones, or itself.
    fn cloned(&self, id: ExprId) -> ExprId {
        match &self.body().expr(id).kind {
            ExprKind::MethodCall { receiver, method, args, .. } if method == "clone" && args.is_empty() => *receiver,
            _ => id,
        }
    }

    /// Whether a method that takes `self` gives it back with some of its state: `fn with_gain(self, gain: f32) -> Self`.
    fn gives_itself_back(&self, call: ExprId, ty: &Ty) -> bool {
        let Some(Callee::Resolved(resolved)) = self.typed().callees.get(&call) else { return false };
        let state = self.state_fields(ty);
        resolved.targets.iter().any(|target| {
            let function = &self.program.index.function(*target).function;
            let (Some(body), Some(typed)) = (&function.body, self.program.typed(*target)) else { return false };
            let is_self = |expr: ExprId| {
                typed.expr_local.get(&expr).is_some_and(|local| typed.locals[local.0 as usize].name == "self")
            };
            let tail = match &body.expr(body.root).kind {
                ExprKind::Block(block) => block.tail,
                _ => Some(body.root),
            };
            let gives = |tail: ExprId| match &body.expr(tail).kind {
                ExprKind::Struct { fields, rest: Some(rest), .. } => {
                    is_self(*rest)
                        && (state.is_empty() || !state.iter().all(|name| fields.iter().any(|(own, _)| own == name)))
                }
                // What it writes first may be all of it.
                _ => {
                    is_self(tail)
                        && !written_fields(self.program, *target).is_none_or(|written| state.is_subset(&written))
                }
            };
            function.receiver == Some(crate::syntax::tree::Receiver::Value) && tail.is_some_and(gives)
        })
    }
}
