//! Guards and names: how a guard gets to a name, and from there to where the value goes.

use super::{Builder, ClosureRef, Value};
use crate::flow::{Cause, Effect, GuardId, Place, Var};
use crate::index::{Shape, Ty};
use crate::source::Span;
use crate::syntax::tree::ExprId;
use crate::types::Resolved;

/// How deep a guard is looked for in what owns it.
const MAX_DEPTH: u32 = 3;

impl Builder<'_> {
    /// A variable that a guard, or something with a guard in it, is bound to: the guard lives to the end of the block.
    pub(super) fn bind_guard(&mut self, var: Var, value: &Value, span: Span) {
        if self.at.is_none() {
            return;
        }
        let scope = self.innermost();
        if self.adopt(var, value, scope, span) {
            return;
        }
        if !self.is_guard_ty(&self.graph.var(var).ty.clone()) {
            return self.bind_destructor(var, value, span);
        }
        let from = value.place.as_ref().and_then(Place::base_var);
        let known = from.and_then(|from| self.guards_of.get(&from)).copied();
        let id = known.unwrap_or_else(|| self.add_guard(span, Vec::new(), Vec::new(), Vec::new()));
        self.name_guard(id, var, scope, span);
    }

    /// Guards that no name held go into a variable.
    pub(super) fn adopt(&mut self, var: Var, value: &Value, scope: usize, span: Span) -> bool {
        let made = value.place.as_ref().map(|place| self.take_made(place)).unwrap_or_default();
        let is_any = !made.is_empty();
        for made in made {
            let from = made.place.base_var();
            let id = self.guard_from(made);
            self.guards_of.extend(from.map(|from| (from, id)));
            self.name_guard(id, var, scope, span);
        }
        is_any
    }

    pub(super) fn name_guard(&mut self, id: GuardId, var: Var, scope: usize, span: Span) {
        self.guards_of.insert(var, id);
        // Another arm may bind it again, where the scope of the first one has ended.
        let is_alive = self.scopes.iter().any(|scope| scope.guards.contains(&id));
        let name = self.graph.vars[var.0 as usize].name.clone();
        let info = &mut self.graph.guards[id.0 as usize];
        info.name.get_or_insert(name);
        if info.forgotten.is_none() && !is_alive {
            self.guard_scopes.insert(var, scope);
            self.start_guard(id, scope, span);
        }
    }

    /// `guard = Guard::new(&mut filter)`: the guard that was there before ends, the new one lives as long as the variable.
    pub(super) fn assign_guard(&mut self, var: Var, value: &Value, span: Span) -> bool {
        let is_made = value.place.as_ref().is_some_and(|place| self.is_made(place));
        let Some(scope) = self.guard_scopes.get(&var).copied().filter(|_| is_made && self.at.is_some()) else {
            return false;
        };
        if let Some(before) = self.guards_of.get(&var).copied() {
            self.end_now(before, span);
        }
        self.adopt(var, value, scope, span);
        self.set(var, &Value { place: None, ..value.clone() }, span);
        true
    }

    /// The guard that lives on where a value goes.
    pub(super) fn moved_guard(&self, value: &Value) -> Option<GuardId> {
        let place = value.place.as_ref().filter(|place| value.is_owned && place.steps.is_empty())?;
        let var = place.base_var()?;
        let id = self.guards_of.get(&var).copied()?;
        let may_be = self.graph.guards[id.0 as usize].is_destructor || self.has_guard(&self.graph.var(var).ty, 0);
        may_be.then_some(id)
    }

    /// Whether a value of the type may be a guard or own one.
    pub(super) fn has_guard(&self, ty: &Ty, depth: u32) -> bool {
        let index = self.program.index;
        let is_in = |inner: &Ty| self.has_guard(inner, depth + 1);
        if depth > MAX_DEPTH || self.is_guard_ty(ty) {
            return depth <= MAX_DEPTH;
        }
        match ty {
            Ty::Tuple(parts) | Ty::External(_, parts) => parts.iter().any(is_in),
            Ty::Array(inner, _) => is_in(inner),
            Ty::Adt(id, _) => match &index.type_def(*id).shape {
                Shape::Struct(fields) => {
                    fields.fields.iter().any(|field| index.field_ty(ty, None, &field.name).is_some_and(|ty| is_in(&ty)))
                }
                Shape::Enum(_) => false,
            },
            _ => false,
        }
    }

    /// A call of analysed code that gives a guard: it is read here, so that what the guard holds is known.
    pub(super) fn guard_from_call(
        &mut self,
        id: ExprId,
        resolved: &Resolved,
        exprs: &[ExprId],
        values: &[Value],
    ) -> Value {
        let span = self.span(id);
        if let [target] = resolved.targets.as_slice()
            && let Some(value) = self.inline_function(*target, values, span)
        {
            return Value { is_owned: true, ..value };
        }
        let is_lent = |(expr, value): (&ExprId, &Value)| {
            value.place.clone().filter(|_| !self.is_shared(*expr) && self.may_hold_filter(self.ty(*expr)))
        };
        let places: Vec<Place> = exprs.iter().zip(values).filter_map(is_lent).collect();
        let result = self.emit_call(id, &resolved.targets, exprs, values, None);
        if !places.is_empty() {
            let cause = Cause::Code("which guard a call of many bodies gives".to_owned());
            self.emit(Effect::Unknown { places, cause }, span);
        }
        Value { place: Some(Place::var(result)), is_owned: true, same_as: Some(result), ..Value::default() }
    }

    /// `condition.then(|| Guard::new(&mut filter))`
    pub(super) fn guard_if_true(&mut self, id: ExprId, value: &Value, receiver: ExprId, closure: ClosureRef) -> Value {
        let span = self.span(id);
        let about = self.about(receiver);
        let (holds, fails) = self.branch_on_head(value, "true", "false", span, self.text(receiver), about);
        let join = self.new_join(self.ty(id).clone(), span);
        self.resume(holds);
        let given = self.inline_closure(closure, &[], span);
        self.end_branch(&join, &Value { head: Some("+".to_owned()), same_as: None, ..given }, span);
        self.resume(fails);
        self.end_branch(&join, &Value { head: Some("-".to_owned()), ..Value::default() }, span);
        Value { is_owned: true, ..self.close_join(&join) }
    }

    /// A guard that is written as a literal holds what its fields are given.
    pub(super) fn note_literal(&mut self, id: ExprId, value: &Value) {
        let ty = self.ty(id).clone();
        if let Some(place) = value.place.clone().filter(|_| self.at.is_some())
            && self.program.index.guard_spec(&ty).is_some()
        {
            let span = self.span(id);
            let given = self.filter_fields(&ty).into_iter().map(|(field, ty)| (field.clone(), place.field(&field), ty));
            self.note_made(place.clone(), given.collect(), span);
        }
    }
}
