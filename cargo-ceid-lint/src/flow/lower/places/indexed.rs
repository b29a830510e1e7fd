//! `value[key]` of a type of the analysed code: what its `index` or `index_mut` does, and which place that hands out.

use super::super::derefs::field_steps;
use super::super::sources::is_map;
use super::super::{Builder, Value};
use crate::flow::{Cause, Effect, Place, Steps};
use crate::index::{FunctionId, Ty};
use crate::syntax::tree::{Body, ExprId, ExprKind, PatKind};
use crate::types::{Indexed, TypedBody};

impl Builder<'_> {
    /// Runs what `[]` runs: what it gives, or the collection of which an element is meant.
    pub(super) fn indexed(
        &mut self,
        id: ExprId,
        base: ExprId,
        index: ExprId,
        value: Value,
        index_value: &Value,
    ) -> Result<Value, Value> {
        let Some(own) = self.typed().indexed.get(&id).cloned() else {
            self.lose_indexed(id, base, &value);
            return Err(value);
        };
        let span = self.span(base);
        let mut through =
            |place: Place| own.derefs.iter().fold(place, |place, through| self.dereferenced(place, *through, span));
        let value = Value { place: value.place.map(&mut through), ..value };
        if let Some(steps) = self.steps_to_collection(&own) {
            return Err(Value { place: value.place.map(|place| place.join(&steps)), ..value });
        }
        let result = self.emit_call(id, &own.targets, &[base, index], &[value, index_value.clone()], None);
        if own.is_exclusive {
            self.note_lent(base);
        }
        if let Some(field) = self.field_lent_by(&own.targets, base).filter(|_| own.derefs.is_empty()) {
            return Ok(Value { place: Some(field), is_owned: true, ..Value::default() });
        }
        // It is a place behind the reference that `index` gives: read as a value, it is copied.
        let lent = &mut self.graph.vars[result.0 as usize].ty;
        *lent = Ty::Ref(own.is_exclusive, Box::new(std::mem::replace(lent, Ty::Unknown)));
        Ok(Value { place: Some(Place::var(result)), is_owned: true, ..Value::default() })
    }

    /// What is indexed may be of any type that has its own `[]`.
    fn lose_indexed(&mut self, id: ExprId, base: ExprId, value: &Value) {
        let ty = self.ty(base);
        if !matches!(ty, Ty::Ref(false, _))
            && matches!(ty.peel(), Ty::Param(_) | Ty::Opaque(_))
            && self.program.index.says_what_indexing_means()
            && let Some(place) = value.place.clone().filter(|_| self.at.is_some())
        {
            self.emit(Effect::Unknown { places: vec![place], cause: Cause::Call(self.text(id)) }, self.span(id));
        }
    }

    /// The collection of whose elements `base[index]` is one, if `[]` does nothing but name it.
    pub(super) fn indexed_place(&self, id: ExprId, base: Place) -> Option<Place> {
        let Some(own) = self.typed().indexed.get(&id) else { return Some(base) };
        let steps = self.steps_to_collection(own)?;
        Some(own.derefs.iter().fold(base, |place, through| self.named_by_deref(place, *through)).join(&steps))
    }

    /// The way from `self` to the collection of which `[]` hands out the element of that number.
    fn steps_to_collection(&self, own: &Indexed) -> Option<Steps> {
        let mut all = own.targets.iter().map(|target| self.steps_to_own(*target));
        let Some(first) = all.next() else { return Some(Steps::default()) };
        first.filter(|first| all.all(|steps| steps.as_ref() == Some(first)))
    }

    fn steps_to_own(&self, function: FunctionId) -> Option<Steps> {
        let body = self.program.index.function(function).function.body.as_ref()?;
        let typed = self.program.typed(function)?;
        let mut at = body.root;
        while let ExprKind::Block(block) = &body.expr(at).kind {
            at = block.tail.filter(|_| block.stmts.is_empty())?;
        }
        while let ExprKind::Reference { value, .. } = &body.expr(at).kind {
            at = *value;
        }
        match &body.expr(at).kind {
            ExprKind::Index { base, index }
                if !typed.indexed.contains_key(&at)
                    && !is_map(typed.ty(*base).peel())
                    && is_parameter(body, typed, *index) =>
            {
                field_steps(body, *base)
            }
            _ => None,
        }
    }
}

/// Whether an expression is what `[]` is given, or its number.
fn is_parameter(body: &Body, typed: &TypedBody, id: ExprId) -> bool {
    match &body.expr(id).kind {
        ExprKind::Cast { value, .. } => is_parameter(body, typed, *value),
        _ => {
            let param = body.params.get(1).filter(|pat| matches!(body.pat(**pat).kind, PatKind::Bind { .. }));
            let local = param.and_then(|pat| typed.pat_local.get(pat));
            local.is_some() && typed.expr_local.get(&id) == local
        }
    }
}
