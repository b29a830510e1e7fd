//! Resets that are known by their names: whether their bodies write the whole state.

use super::Builder;
use crate::index::{FunctionId, Ty};
use crate::syntax::tree::{ExprId, ExprKind};
use crate::types::Callee;

impl Builder<'_> {
    /// Whether a reset known by its name writes the whole state: every field that the law writes, or `*self`.
    pub(super) fn is_full_reset(&self, reset: FunctionId, self_ty: &Ty) -> bool {
        let index = self.program.index;
        let Some(cleared) = self.written_fields(reset, 0) else { return true };
        let laws = index.methods(self_ty, "update");
        let mut state = std::collections::BTreeSet::new();
        for law in laws.iter().filter_map(crate::index::MethodOwner::function) {
            match self.written_fields(law, 0) {
                Some(fields) => state.extend(fields),
                None => return !cleared.is_empty(),
            }
        }
        state.is_subset(&cleared)
    }

    /// The fields that the laws of a filter type write; none if that cannot be seen.
    pub(super) fn state_fields(&self, ty: &Ty) -> std::collections::BTreeSet<String> {
        let index = self.program.index;
        let Some(spec) = index.filter_spec(ty) else { return std::collections::BTreeSet::new() };
        let methods = spec.law.iter().flat_map(|group| &group.methods).flat_map(|name| index.methods(ty, name));
        let laws = methods.filter_map(|owner| owner.function());
        let mut state = std::collections::BTreeSet::new();
        for law in laws {
            match self.written_fields(law, 0) {
                Some(fields) => state.extend(fields),
                None => return std::collections::BTreeSet::new(),
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
            ExprKind::MethodCall { receiver, method, .. } if method == "clone" => {
                self.static_place(*receiver) == Some(old)
            }
            ExprKind::MethodCall { receiver, .. } if self.static_place(*receiver).as_ref() == Some(&old) => {
                self.gives_itself_back(value, &ty)
            }
            ExprKind::Struct { fields, rest, .. } => {
                let is_rest = rest.is_some_and(|rest| self.static_place(rest).as_ref() == Some(&old));
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
                _ => is_self(tail) && !self.written_fields(*target, 0).is_none_or(|written| state.is_subset(&written)),
            };
            function.receiver == Some(crate::syntax::tree::Receiver::Value) && tail.is_some_and(gives)
        })
    }

    /// The fields of `self` that a function writes; `None` if it writes all of it, or hands it to something else.
    fn written_fields(&self, id: FunctionId, depth: u32) -> Option<std::collections::BTreeSet<String>> {
        let def = self.program.index.function(id);
        let (Some(body), Some(typed)) = (&def.function.body, self.program.typed(id)) else { return None };
        if depth > 4 {
            return None;
        }
        let self_local = typed.locals.iter().position(|local| local.name == "self")?;
        let is_self = |expr: ExprId| typed.expr_local.get(&expr).is_some_and(|local| local.0 as usize == self_local);
        let field_of_self = |expr: ExprId| -> Option<String> {
            let mut at = expr;
            loop {
                match &body.expr(at).kind {
                    ExprKind::Field { base, name } if is_self(*base) => return Some(name.clone()),
                    ExprKind::Field { base, .. } | ExprKind::Index { base, .. } => at = *base,
                    ExprKind::Deref(inner) | ExprKind::Reference { value: inner, .. } => at = *inner,
                    ExprKind::MethodCall { receiver, .. } => at = *receiver,
                    _ => return None,
                }
            }
        };
        let mut fields = std::collections::BTreeSet::new();
        for (number, expr) in body.exprs.iter().enumerate() {
            match &expr.kind {
                ExprKind::Assign { place, .. } | ExprKind::AssignOp { place, .. } => {
                    if let ExprKind::Deref(inner) = &body.expr(*place).kind
                        && is_self(*inner)
                    {
                        return None;
                    }
                    fields.extend(field_of_self(*place));
                }
                ExprKind::Reference { mutable: true, value, .. } => fields.extend(field_of_self(*value)),
                ExprKind::MethodCall { receiver, .. } => {
                    let call = ExprId(u32::try_from(number).unwrap_or(u32::MAX));
                    let writes = match typed.callees.get(&call) {
                        Some(Callee::Resolved(resolved)) => resolved.targets.iter().any(|target| {
                            self.program.index.function(*target).function.receiver
                                == Some(crate::syntax::tree::Receiver::Exclusive)
                        }),
                        _ => !matches!(typed.ty(*receiver).peel(), Ty::Int | Ty::Float | Ty::Bool),
                    };
                    if is_self(*receiver) {
                        if let Some(Callee::Resolved(resolved)) = typed.callees.get(&call) {
                            for target in &resolved.targets {
                                fields.extend(self.written_fields(*target, depth + 1)?);
                            }
                        }
                    } else if writes {
                        fields.extend(field_of_self(*receiver));
                    }
                }
                _ => {}
            }
        }
        Some(fields)
    }
}
